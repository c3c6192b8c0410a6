"""python mitsuba_peer.py SCENE SIDE SAMPLES SEED OUT.npy: a square picture by Mitsuba 3's path tracer."""
import os
import sys
import tempfile

import mitsuba as mi
import numpy as np

import gltf_scene

mi.set_variant("llvm_ad_rgb")


def texture_or_color(material, folder):
    if material.base_color_image is None:
        return {"type": "rgb", "value": material.base_color.tolist()}
    name = os.path.join(folder, f"{id(material)}.img")
    with open(name, "wb") as file:
        file.write(material.base_color_image)
    return {"type": "bitmap", "bitmap": mi.Bitmap(name)}


def bsdf_of(material, folder):
    color, alpha = texture_or_color(material, folder), material.roughness ** 2
    if material.transmission == 1:
        if not material.is_solid:
            return {"type": "thindielectric", "int_ior": material.ior, "specular_transmittance": color}
        rough = {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha} if alpha > 0 else {"type": "dielectric"}
        return rough | {"int_ior": material.ior, "specular_transmittance": color}
    if material.transmission > 0:
        return {"type": "principled", "base_color": color, "roughness": material.roughness, "metallic": material.metallic,
                "spec_trans": material.transmission, "eta": material.ior}
    if material.metallic == 1:
        rough = {"type": "roughconductor", "distribution": "ggx", "alpha": alpha} if alpha > 0 else {"type": "conductor"}
        inner = rough | {"material": "none", "specular_reflectance": color}
    elif material.metallic > 0:
        inner = {"type": "principled", "base_color": color, "roughness": material.roughness, "metallic": material.metallic}
    elif material.specular == 0:
        inner = {"type": "diffuse", "reflectance": color}
    else:
        rough = {"type": "roughplastic", "distribution": "ggx", "alpha": alpha} if alpha > 0 else {"type": "plastic"}
        inner = rough | {"int_ior": material.ior, "diffuse_reflectance": color, "nonlinear": True}
    return {"type": "twosided", "bsdf": inner}


def shape_of(mesh, scene, bsdfs, index):
    material = scene.materials[mesh.material]
    props = mi.Properties()
    props["bsdf"] = bsdfs[mesh.material]
    if material.emission.any():
        props["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": material.emission.tolist()}})
    if material.is_solid and material.attenuation.any():
        props["interior"] = mi.load_dict({"type": "homogeneous", "albedo": 0.0,
                                          "sigma_t": {"type": "rgb", "value": material.attenuation.tolist()}})
    shape = mi.Mesh(f"mesh{index}", len(mesh.positions), len(mesh.triangles), props=props,
                    has_vertex_normals=mesh.normals is not None, has_vertex_texcoords=mesh.uvs is not None)
    values = mi.traverse(shape)
    values["vertex_positions"] = mesh.positions.astype(np.float32).ravel()
    values["faces"] = mesh.triangles.astype(np.uint32).ravel()
    if mesh.normals is not None:
        values["vertex_normals"] = mesh.normals.astype(np.float32).ravel()
    if mesh.uvs is not None:
        values["vertex_texcoords"] = mesh.uvs.astype(np.float32).ravel()
    values.update()
    return shape


def light_of(light):
    color = {"type": "rgb", "value": light.color.tolist()}
    if light.kind == "point":
        return {"type": "point", "position": light.position.tolist(), "intensity": color}
    if light.kind == "directional":
        return {"type": "directional", "direction": light.direction.tolist(), "irradiance": color}
    towards = mi.ScalarTransform4f().look_at(light.position.tolist(), (light.position + light.direction).tolist(),
                                             [0.0, 0.6, 0.8])
    return {"type": "spot", "to_world": towards, "intensity": color, "cutoff_angle": float(np.degrees(light.outer)),
            "beam_width": float(np.degrees(light.inner))}


def main():
    path, side, samples, seed, out = sys.argv[1], *map(int, sys.argv[2:5]), sys.argv[5]
    scene = gltf_scene.load(path)
    # glTF's camera looks along -z, Mitsuba's along +z with x to the left.
    camera = scene.camera_to_world @ np.diag([-1.0, 1.0, -1.0, 1.0])
    with tempfile.TemporaryDirectory() as folder:
        bsdfs = [mi.load_dict(bsdf_of(material, folder)) for material in scene.materials]
        has_media = any(m.is_solid and m.attenuation.any() for m in scene.materials)
        picture = {"type": "scene", "integrator": {"type": "volpath" if has_media else "path"},
                   "sensor": {"type": "perspective", "fov": float(np.degrees(scene.fov)), "fov_axis": "y",
                              "to_world": mi.ScalarTransform4f(camera),
                              "film": {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}}}}
        for i, mesh in enumerate(scene.meshes):
            picture[f"mesh{i}"] = shape_of(mesh, scene, bsdfs, i)
        for i, light in enumerate(scene.lights):
            picture[f"light{i}"] = light_of(light)
        loaded = mi.load_dict(picture)
    total, done = np.zeros((side, side, 3)), 0
    while done < samples:  # in passes that fit into memory
        here = min(samples - done, max(1, (1 << 22) // side**2))
        total += here * np.array(mi.render(loaded, spp=here, seed=seed * 4096 + done), dtype=float)[..., :3]
        done += here
    np.save(out, total / samples)


main()
