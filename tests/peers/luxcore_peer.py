"""python luxcore_peer.py SCENE SIDE SAMPLES SEED OUT.npy: a square picture by LuxCore's path tracer (PATHCPU)."""
import os
import sys
import tempfile
import time

import numpy as np
import pyluxcore

import gltf_scene


def words(values):
    return " ".join(repr(float(value)) for value in values)


def material_lines(name, material, folder):
    """Properties of a material, and of the volume and the texture that it needs."""
    prefix, alpha, lines = f"scene.materials.{name}", material.roughness ** 2, []
    color = words(material.base_color)
    if material.base_color_image is not None:
        image = os.path.join(folder, name + (".png" if material.base_color_image[1:4] == b"PNG" else ".jpg"))
        with open(image, "wb") as file:
            file.write(material.base_color_image)
        lines += [f"scene.textures.{name}.type = imagemap", f"scene.textures.{name}.file = {image}",
                  f"scene.textures.{name}.gamma = 2.2", f"scene.textures.{name}.mapping.uvscale = 1 -1"]
        color = name
    if material.transmission > 0:
        kind = "archglass" if not material.is_solid else "glass" if alpha == 0 else "roughglass"
        lines += [f"{prefix}.type = {kind}", f"{prefix}.kr = 1 1 1", f"{prefix}.kt = {color}",
                  f"{prefix}.interiorior = {material.ior}"]
        if kind == "roughglass":
            lines += [f"{prefix}.uroughness = {alpha}", f"{prefix}.vroughness = {alpha}"]
        if material.is_solid and material.attenuation.any():
            lines += [f"scene.volumes.{name}.type = clear", f"scene.volumes.{name}.ior = {material.ior}",
                      f"scene.volumes.{name}.absorption = {words(material.attenuation)}",
                      f"{prefix}.volume.interior = {name}"]
    elif material.metallic > 0.5:
        if alpha == 0:
            lines += [f"{prefix}.type = mirror", f"{prefix}.kr = {color}"]
        else:
            lines += [f"scene.textures.{name}f.type = fresnelcolor", f"scene.textures.{name}f.kr = {color}",
                      f"{prefix}.type = metal2", f"{prefix}.fresnel = {name}f", f"{prefix}.uroughness = {alpha}",
                      f"{prefix}.vroughness = {alpha}"]
    elif material.specular == 0:
        lines += [f"{prefix}.type = matte", f"{prefix}.kd = {color}"]
    else:
        lines += [f"{prefix}.type = glossy2", f"{prefix}.kd = {color}", f"{prefix}.ks = 0 0 0",
                  f"{prefix}.index = {material.ior}", f"{prefix}.uroughness = {max(alpha, 1e-3)}",
                  f"{prefix}.vroughness = {max(alpha, 1e-3)}"]
    if material.emission.any():
        lines += [f"{prefix}.emission = {words(material.emission)}"]
        if not material.is_double_sided:
            lines += [f"{prefix}.emission.theta = 90"]
    return lines


def light_lines(name, light):
    prefix, lines = f"scene.lights.{name}", [f"scene.lights.{name}.color = {words(light.color)}"]
    if light.kind == "directional":
        return lines + [f"{prefix}.type = sharpdistant", f"{prefix}.direction = {words(light.direction)}"]
    lines += [f"{prefix}.position = {words(light.position)}"]
    if light.kind == "point":
        return lines + [f"{prefix}.type = point"]
    return lines + [f"{prefix}.type = spot", f"{prefix}.target = {words(light.position + light.direction)}",
                    f"{prefix}.coneangle = {np.degrees(light.outer)}",
                    f"{prefix}.conedeltaangle = {np.degrees(light.outer - light.inner)}"]


def properties(lines):
    result = pyluxcore.Properties()
    result.SetFromString("\n".join(lines))
    return result


def main():
    path, side, samples, seed, out = sys.argv[1], *map(int, sys.argv[2:5]), sys.argv[5]
    pyluxcore.Init(lambda message: None)
    gltf = gltf_scene.load(path)
    origin = gltf.camera_to_world[:3, 3]
    # A picture's shorter side has the field of view.
    lines = ["scene.camera.type = perspective", f"scene.camera.fieldofview = {np.degrees(gltf.fov)}",
             f"scene.camera.lookat.orig = {words(origin)}",
             f"scene.camera.lookat.target = {words(origin - gltf.camera_to_world[:3, 2])}",
             f"scene.camera.up = {words(gltf.camera_to_world[:3, 1])}"]
    scene = pyluxcore.Scene()
    with tempfile.TemporaryDirectory() as folder:
        for i, material in enumerate(gltf.materials):
            lines += material_lines(f"m{i}", material, folder)
        for i, mesh in enumerate(gltf.meshes):
            rows = lambda array: None if array is None else [tuple(map(float, row)) for row in array]
            scene.DefineMesh(f"s{i}", rows(mesh.positions), [tuple(map(int, t)) for t in mesh.triangles],
                             rows(mesh.normals), rows(mesh.uvs), None, None)
            lines += [f"scene.objects.o{i}.shape = s{i}", f"scene.objects.o{i}.material = m{mesh.material}"]
        for i, light in enumerate(gltf.lights):
            lines += light_lines(f"l{i}", light)
        scene.Parse(properties(lines))
        config = pyluxcore.RenderConfig(properties([
            "renderengine.type = PATHCPU", "sampler.type = SOBOL", f"renderengine.seed = {seed}",
            f"film.width = {side}", f"film.height = {side}", "film.filter.type = BOX", "film.filter.xwidth = 0.5",
            "film.filter.ywidth = 0.5", f"batch.haltspp = {samples}", "film.outputs.0.type = RGB",
            "film.outputs.0.filename = image.exr"]), scene)
        session = pyluxcore.RenderSession(config)
        session.Start()
        while not session.HasDone():
            time.sleep(0.02)
            session.UpdateStats()
        session.Stop()
        buffer = np.zeros(side * side * 3, dtype=np.float32)
        session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, buffer)
    np.save(out, buffer.reshape(side, side, 3)[::-1].astype(float))


main()
os._exit(0)  # pyluxcore 2.11.2 crashes when Python takes it down
