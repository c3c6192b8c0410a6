"""Goes around a scene, and looks at one path of it: render.py SCENE.gltf FOLDER"""

import math
import sys

import numpy as np
import regulus

scene = regulus.load(sys.argv[1])
device = regulus.open_device()
middle = (np.array(scene.bounds_min) + np.array(scene.bounds_max)) / 2
x, y, z = np.array(scene.cameras[0].position) - middle

for i, angle in enumerate(np.radians([-15, -5, 5, 15])):
    turned = [x * math.cos(angle) + z * math.sin(angle), y, z * math.cos(angle) - x * math.sin(angle)]
    scene.set_camera(0, scene.cameras[0].look_at(middle + turned, middle))
    picture = regulus.render(scene, device=device, size=(48, 48), spp=4, aov=["albedo", "Z"],
                             progress=lambda done, all: print(f"\r{done / all:4.0%}", end="", file=sys.stderr))
    picture.write(f"{sys.argv[2]}/side{i}.exr")
    picture.write(f"{sys.argv[2]}/side{i}.png")
    print(f"side {i}: mean {picture.rgb.mean():.3f}, albedo {picture['albedo'].mean():.3f}")

# Where does the middle of the picture get its light from?
path = regulus.trace_path(scene, 24, 24, device=device, size=(48, 48), integrator="bpt")
print("vertices at", path["vertices"]["position"].round(3).tolist())
for found in path["contributions"]:
    print(found["technique"], "of", dict(zip(found["techniques"], found["weights"].round(3))))
