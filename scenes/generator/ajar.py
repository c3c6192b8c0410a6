"""Two rooms and a door ajar: the lamps are in the other room, and all that is seen is lit through a gap of a hand's breadth.
A path from the camera meets the gap by chance only, once in some hundred times."""
import math

from .gltf import Gltf
from .mesh import Mesh, box, join, quad, sphere
from .solids import turned_about_y
from .vec import look_at

DEPTH, HEIGHT = 4.0, 2.6            # of both rooms: along z, and up
SEEN, LIT = 4.5, 3.5                # their lengths along x, on both sides of the wall at x = 0
WALL, DOOR_WIDTH, DOOR_HEIGHT = 0.12, 0.9, 2.1
HINGE, OPENING = -0.3, 8.0          # z of the door's hinge; degrees
LAMP_RADIANCE = (1800.0, 1560.0, 1200.0)


def room(scene, name, low_x, high_x, wall, floor):
    """Walls but for the one at x = 0, which both rooms share. Fronts face inwards."""
    middle, length = (low_x + high_x) / 2, high_x - low_x
    x, y, z = (length, 0.0, 0.0), (0.0, HEIGHT, 0.0), (0.0, 0.0, DEPTH)
    walls = Mesh([], [], [])
    join(walls, quad((middle, HEIGHT / 2, DEPTH / 2), y, x))
    join(walls, quad((middle, HEIGHT / 2, -DEPTH / 2), x, y))
    join(walls, quad((middle, HEIGHT, 0.0), x, z))
    if low_x < 0.0:
        join(walls, quad((low_x, HEIGHT / 2, 0.0), y, z))
    else:
        join(walls, quad((high_x, HEIGHT / 2, 0.0), z, y))
    scene.add_surface(name + " walls", walls, scene.diffuse(name + " plaster", wall))
    scene.add_surface(name + " floor", quad((middle, 0.0, 0.0), z, x), scene.material(name + " boards", floor, roughness=0.4))


def partition(scene):
    """The wall between the rooms, around the doorway, and the door."""
    wall, half = Mesh([], [], []), WALL / 2
    first, last = HINGE, HINGE + DOOR_WIDTH
    for low, high in (((-half, -0.05, -DEPTH / 2 - 0.05), (half, HEIGHT + 0.05, first)),
                      ((-half, -0.05, last), (half, HEIGHT + 0.05, DEPTH / 2 + 0.05)),
                      ((-half, DOOR_HEIGHT, first - 0.01), (half, HEIGHT + 0.05, last + 0.01))):
        join(wall, box(low, high))
    scene.add_surface("partition", wall, scene.diffuse("partition plaster", (0.72, 0.70, 0.66)))
    door = turned_about_y(box((-0.02, 0.004, 0.004), (0.02, DOOR_HEIGHT - 0.004, DOOR_WIDTH)), OPENING, (half, 0.0, HINGE))
    scene.add_surface("door", door, scene.material("paint", (0.62, 0.58, 0.5), roughness=0.35))


def things(scene):
    scene.add_surface("chest", box((2.1, 0.0, -1.9), (3.3, 0.75, -1.35)), scene.material("oak", (0.45, 0.29, 0.16), roughness=0.5))
    ball = scene.geometry(sphere(20))
    scene.add_mesh("clay ball", ball, scene.diffuse("clay", (0.62, 0.33, 0.22)), (2.4, 0.96, -1.62), 0.21)
    scene.add_mesh("glass ball", ball, scene.glass("glass", 1.5), (1.5, 0.31, -0.35), 0.3)
    scene.add_mesh("steel ball", ball, scene.metal("steel", (0.7, 0.7, 0.72), 0.25), (2.95, 0.93, -1.6), 0.18)


def build():
    scene = Gltf("A door ajar", (320, 240), {"integrator": "pt", "spp": 256, "max-depth": 10})
    room(scene, "seen", 0.0, SEEN, (0.74, 0.72, 0.68), (0.34, 0.23, 0.15))
    room(scene, "lit", -LIT, 0.0, (0.80, 0.78, 0.74), (0.34, 0.23, 0.15))
    partition(scene)
    things(scene)
    lamps = Mesh([], [], [])
    join(lamps, quad((-1.6, HEIGHT - 0.02, -0.9), (0.4, 0.0, 0.0), (0.0, 0.0, 0.4)))
    join(lamps, quad((-LIT + 0.02, 1.5, 0.9), (0.0, 0.3, 0.0), (0.0, 0.0, 0.3)))
    scene.add_surface("lamps", lamps, scene.light_material("lamp", LAMP_RADIANCE))
    scene.perspective_camera(look_at((4.2, 1.5, 1.6), (1.2, 0.85, -0.9)), math.radians(52.0), 4.0 / 3.0)
    return {"ajar": scene}
