"""python cycles_peer.py SCENE SIDE SAMPLES SEED OUT.npy: a square picture by Cycles, which imports the glTF file itself.

Its settings are the defaults, but for adaptive sampling and the denoiser, which are off: samples are counted here. Lights
keep the file's numbers (lighting mode COMPAT): by default the importer divides those of point lights and suns by 683.
"""
import os
import sys
import tempfile

import bpy
import numpy as np

import gltf_scene


def main():
    path, side, samples, seed, out = sys.argv[1], *map(int, sys.argv[2:5]), sys.argv[5]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath(path), export_import_convert_lighting_mode="COMPAT")
    scene = bpy.context.scene
    scene.camera = next(thing for thing in scene.objects if thing.type == "CAMERA")
    scene.camera.data.sensor_fit = "VERTICAL"
    scene.camera.data.angle_y = gltf_scene.fov_of_square(gltf_scene.parsed(path)[0]["cameras"][0]["perspective"])
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = side
    scene.render.resolution_percentage = 100
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "picture.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.array(image.pixels[:]).reshape(side, side, 4)
    np.save(out, pixels[::-1, :, :3])


main()
