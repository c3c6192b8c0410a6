"""Views that are small beside their scene: a room with a window under a sky dome of 400 m, and a still life on a plain
of a kilometre. Nothing that is seen is farther away than a few metres, so nothing that a renderer chooses may follow from the
bounds."""
import math

from .gltf import Gltf
from .mesh import Mesh, boxes, quad, sphere
from .vec import look_at

DOME_RADIUS, SKY = 400.0, (4.5, 5.2, 6.0)
WIDTH, HEIGHT, DEPTH, WALL = 5.0, 3.0, 4.0, 0.1  # of the room, inside
WINDOW = ((-1.7, 0.6), (1.7, 2.7))  # (z, y) of its corners, in the wall at +x
PLAIN = 1000.0
SOFTBOX, SOFTBOX_RADIANCE = 0.8, (12.0, 11.0, 10.0)


def room():
    """Walls overlap in the room's edges, so that no light passes there."""
    x, z = WIDTH / 2, DEPTH / 2
    (z0, y0), (z1, y1) = WINDOW
    return boxes(
        ((-x - WALL, -WALL, -z - WALL), (x + WALL, 0.0, z + WALL)),                # floor
        ((-x - WALL, HEIGHT, -z - WALL), (x + WALL, HEIGHT + WALL, z + WALL)),     # ceiling
        ((-x - WALL, 0.0, -z - WALL), (-x, HEIGHT, z + WALL)),                     # left
        ((-x, 0.0, -z - WALL), (x + WALL, HEIGHT, -z)),                            # back
        ((-x, 0.0, z), (x + WALL, HEIGHT, z + WALL)),                              # front
        ((x, 0.0, -z), (x + WALL, y0, z)), ((x, y1, -z), (x + WALL, HEIGHT, z)),   # right: below and above the window
        ((x, y0, -z), (x + WALL, y1, z0)), ((x, y0, z1), (x + WALL, y1, z)))       # and beside it


def room_under_dome():
    scene = Gltf("A room with a window under a sky dome", (384, 256), {"spp": 256, "max-depth": 8})
    scene.add_surface("room", room(), scene.diffuse("plaster", (0.75, 0.72, 0.66)))
    scene.add_surface("table", boxes(((-0.9, 0.7, -1.2), (0.7, 0.75, -0.2)), ((-0.15, 0.0, -0.75), (-0.05, 0.7, -0.65))),
                      scene.diffuse("wood", (0.45, 0.28, 0.16)))
    scene.add_mesh("vase", scene.geometry(sphere(12)), scene.material("glaze", (0.2, 0.35, 0.5), roughness=0.3), (-0.3, 0.95, -0.7),
                   0.2)
    scene.add_surface("ground", quad((0.0, -WALL - 0.01, 0.0), (0.0, 0.0, 300.0), (300.0, 0.0, 0.0)),
                      scene.diffuse("grass", (0.2, 0.3, 0.12)))
    dome = sphere(4).flat().turned_inside_out()
    scene.add_mesh("sky", scene.geometry(Mesh(dome.positions, dome.triangles)), scene.light_material("sky", SKY), None, DOME_RADIUS)
    scene.perspective_camera(look_at((1.6, 1.7, 1.8), (-0.9, 1.1, -1.4)), math.radians(62.0), 1.5)
    return scene


def still_life_on_plain():
    scene = Gltf("A still life on a plain of a kilometre", (384, 256), {"spp": 256, "max-depth": 8})
    scene.add_surface("plain", quad((0.0, 0.0, 0.0), (0.0, 0.0, PLAIN), (PLAIN, 0.0, 0.0)), scene.diffuse("sand", (0.5, 0.45, 0.38)))
    scene.add_surface("crate", boxes(((-0.32, 0.001, -0.2), (-0.02, 0.301, 0.1))), scene.diffuse("card", (0.6, 0.4, 0.22)))
    ball = scene.geometry(sphere(16))
    scene.add_mesh("brass ball", ball, scene.metal("brass", (0.9, 0.7, 0.35), 0.35), (0.16, 0.121, 0.06), 0.12)
    scene.add_mesh("glazed ball", ball, scene.material("glaze", (0.6, 0.1, 0.08), roughness=0.25), (0.38, 0.091, -0.1), 0.09)
    # Faces down and to the still life.
    softbox = quad((-0.4, 1.1, 0.5), (SOFTBOX, 0.0, 0.0), (0.0, -0.5 * SOFTBOX, 0.7 * SOFTBOX))
    scene.add_surface("softbox", softbox, scene.light_material("softbox", SOFTBOX_RADIANCE))
    scene.environment((0.3, 0.35, 0.45))
    scene.perspective_camera(look_at((0.25, 0.55, 1.5), (0.05, 0.12, 0.0)), math.radians(38.0), 1.5)
    return scene


def build():
    return {"room-under-dome": room_under_dome(), "still-life-on-plain": still_life_on_plain()}
