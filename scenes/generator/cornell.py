"""The Cornell box in its true size (0.5528 x 0.5488 x 0.5592 m) with a mirror and a glass sphere."""
import math

from .gltf import Gltf
from .mesh import Mesh, join, quad, sphere
from .vec import look_at

WIDTH, HEIGHT, DEPTH = 0.5528, 0.5488, 0.5592
WHITE, RED, GREEN = (0.74, 0.73, 0.70), (0.58, 0.06, 0.05), (0.12, 0.42, 0.09)
LIGHT_SIZE = (0.16, 0.13)
LIGHT_RADIANCE = (18.0, 14.6, 10.8)
SPHERE_RADIUS = 0.12
LIFT = 0.0002  # spheres hover by 0.2 mm: no vertex lies in the floor's plane


def build():
    scene = Gltf("Cornell box with a mirror and a glass sphere", (512, 512),
                 {"spp": 256, "max-depth": 16, "exposure": 0})
    x, y, z = (WIDTH, 0.0, 0.0), (0.0, HEIGHT, 0.0), (0.0, 0.0, DEPTH)
    mid_y, mid_z = HEIGHT / 2, -DEPTH / 2

    white_walls = Mesh([], [], [])
    join(white_walls, quad((0.0, 0.0, mid_z), z, x))           # floor
    join(white_walls, quad((0.0, HEIGHT, mid_z), x, z))        # ceiling
    join(white_walls, quad((0.0, mid_y, -DEPTH), x, y))        # back
    scene.add_surface("white walls", white_walls, scene.diffuse("white", WHITE))
    scene.add_surface("red wall", quad((-WIDTH / 2, mid_y, mid_z), y, z), scene.diffuse("red", RED))
    scene.add_surface("green wall", quad((WIDTH / 2, mid_y, mid_z), z, y), scene.diffuse("green", GREEN))

    lamp = quad((0.0, HEIGHT - 0.001, mid_z), (LIGHT_SIZE[0], 0.0, 0.0), (0.0, 0.0, LIGHT_SIZE[1]))
    scene.add_surface("lamp", lamp, scene.light_material("lamp", LIGHT_RADIANCE))

    ball = scene.geometry(sphere(32))
    height = SPHERE_RADIUS + LIFT
    scene.add_mesh("mirror sphere", ball, scene.metal("mirror", (0.95, 0.95, 0.95), 0.0),
                   (-0.13, height, -0.39), SPHERE_RADIUS)
    scene.add_mesh("glass sphere", ball, scene.glass("glass", 1.5), (0.13, height, -0.19), SPHERE_RADIUS)

    # The original stands 0.8 m before the open side; this frame is the opening, less 1 mm on each edge.
    scene.perspective_camera(look_at((0.0, mid_y, 0.8), (0.0, mid_y, 0.0)), 2 * math.atan2(mid_y - 0.001, 0.8))
    return {"cornell": scene}
