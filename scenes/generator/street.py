"""A small yard in a wide street scene: a sun and 37 lamps shine on a plain of 240 metres, and the camera looks into
six metres of it. Of light paths that start by power hardly one in a thousand comes where it is seen."""
import math

from .gltf import Gltf
from .mesh import Mesh, box, join, quad, sphere
from .solids import lathe, line, turned_about_y
from .vec import look_at

PLAIN = 240.0
YARD, WALL_HEIGHT, WALL = 3.0, 2.6, 0.2  # half its side, inside
SUN_DIRECTION, SUN = (-0.55, -0.75, -0.36), 3.0
LAMP_HEIGHT, LAMP_INTENSITY = 5.5, 900.0
PANEL_RADIANCE = (260.0, 240.0, 200.0)


def yard(scene):
    walls = Mesh([], [], [])
    inner, outer = YARD, YARD + WALL
    for low, high in (((-outer, -0.1, -outer), (outer, WALL_HEIGHT, -inner)), ((-outer, -0.1, inner), (outer, WALL_HEIGHT, outer)),
                      ((-outer, -0.1, -inner - 0.05), (-inner, WALL_HEIGHT, inner + 0.05)),
                      ((inner, -0.1, -inner - 0.05), (outer, WALL_HEIGHT, inner + 0.05))):
        join(walls, box(low, high))
    scene.add_surface("walls", walls, scene.diffuse("brick", (0.55, 0.30, 0.22)))
    scene.add_surface("paving", box((-inner, -0.05, -inner), (inner, 0.02, inner)), scene.diffuse("paving", (0.55, 0.53, 0.50)))
    scene.add_surface("bench", box((-2.6, 0.42, -2.7), (-0.4, 0.48, -2.2)), scene.diffuse("wood", (0.45, 0.28, 0.16)))


def things(scene):
    ball = scene.geometry(sphere(20))
    scene.add_mesh("glass ball", ball, scene.glass("glass", 1.5), (0.5, 0.47, -0.9), 0.45)
    scene.add_mesh("mirror ball", ball, scene.metal("mirror", (0.9, 0.9, 0.9), 0.0), (-1.1, 0.37, -0.4), 0.35)
    # A ring of polished brass: the sun draws its curve inside of it.
    ring = lathe([line((0.50, 0.0), (0.50, 0.22)), line((0.50, 0.22), (0.48, 0.22)), line((0.48, 0.22), (0.48, 0.0)),
                  line((0.48, 0.0), (0.50, 0.0))], 96)
    scene.add_surface("ring", turned_about_y(ring, 0.0, (0.2, 0.021, 0.6)), scene.metal("brass", (0.9, 0.7, 0.35), 0.1))


def town(scene):
    """Houses beyond the yard, and lamps along the streets between them: points, and panels that face down."""
    houses, panels = Mesh([], [], []), Mesh([], [], [])
    for i in range(-3, 4):
        for k in range(-3, 4):
            x, z = 32.0 * i, 32.0 * k
            if (i, k) != (0, 0) and abs(i) + abs(k) > 1:
                join(houses, box((x - 8.0, -0.1, z - 8.0), (x + 8.0, 6.0 + 2.0 * ((5 * i + 3 * k) % 4), z + 8.0)))
            if (i + k) % 2 == 0:
                join(panels, quad((x + 16.0, LAMP_HEIGHT, z + 16.0), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4)))
            elif abs(i) < 3 and abs(k) < 3:
                scene.point_light((x + 16.0, LAMP_HEIGHT, z + 16.0), LAMP_INTENSITY)
    scene.add_surface("houses", houses, scene.diffuse("plaster", (0.6, 0.57, 0.5)))
    scene.add_surface("panels", panels, scene.light_material("panel", PANEL_RADIANCE))
    scene.add_surface("ground", quad((0.0, 0.0, 0.0), (0.0, 0.0, PLAIN), (PLAIN, 0.0, 0.0)), scene.diffuse("asphalt", (0.2, 0.2, 0.2)))


def build():
    scene = Gltf("A yard in a wide street scene", (384, 256), {"spp": 256, "max-depth": 8})
    yard(scene)
    things(scene)
    town(scene)
    scene.directional_light(SUN_DIRECTION, SUN, (1.0, 0.93, 0.8))
    scene.perspective_camera(look_at((2.3, 2.3, 2.6), (-0.1, 0.45, -0.5)), math.radians(60.0), 1.5)
    return {"street": scene}
