"""A room that the sun and the sky light from outside alone: through a window with a pane of glass, and through an open skylight.
What the sun's beams draw on floor and walls has passed the pane, so that no path from the camera finds it by chance, and of all
light paths that start over the room's roof few come in."""
import math

from .gltf import Gltf
from .mesh import box, boxes, quad, sphere
from .vec import look_at

WIDTH, HEIGHT, DEPTH, WALL = 5.0, 2.8, 4.0, 0.25  # of the room, inside: along x, y, z
WINDOW = ((-1.2, 0.9), (0.6, 2.2))                # (z, y) of its corners, in the wall at +x
SKYLIGHT = ((-1.7, -1.1), (-0.9, -0.3))           # (x, z) of its corners, in the ceiling
PANE = 0.006                                      # thickness of the glass
SUN_DIRECTION, SUN = (-0.70, -0.55, -0.28), 90.0  # where it shines to, W/m^2 before its colour
SKY = (1.1, 1.5, 2.2)


def shell():
    """Walls overlap in the room's edges, so that no light passes there; what lies in one plane only meets."""
    x, z, (z0, y0), (z1, y1) = WIDTH / 2, DEPTH / 2, *WINDOW
    (x2, z2), (x3, z3), top = *SKYLIGHT, HEIGHT + WALL
    return boxes(
        ((-x - WALL, -WALL, -z - WALL), (-x, top, z + WALL)),                      # left
        ((-x, -WALL, -z - WALL), (x + WALL, top, -z)),                             # back
        ((-x, -WALL, z), (x + WALL, top, z + WALL)),                               # front
        ((x, -WALL, -z), (x + WALL, y0, z)), ((x, y1, -z), (x + WALL, top, z)),    # right: below and above the window
        ((x, y0, -z), (x + WALL, y1, z0)), ((x, y0, z1), (x + WALL, y1, z)),       # and beside it
        ((-x, HEIGHT, -z), (x2, top, z)), ((x3, HEIGHT, -z), (x, top, z)),         # ceiling: left and right of the skylight
        ((x2, HEIGHT, -z), (x3, top, z2)), ((x2, HEIGHT, z3), (x3, top, z)))       # and behind and before it


def things(scene):
    scene.add_surface("rug", box((-1.5, -0.01, -1.2), (0.9, 0.008, 0.8)), scene.diffuse("wool", (0.42, 0.12, 0.10)))
    table = boxes(((-0.9, 0.42, -0.6), (0.3, 0.46, 0.2)), ((-0.82, 0.0, -0.52), (-0.76, 0.43, -0.46)), ((0.16, 0.0, -0.52), (0.22, 0.43, -0.46)),
                  ((-0.82, 0.0, 0.06), (-0.76, 0.43, 0.12)), ((0.16, 0.0, 0.06), (0.22, 0.43, 0.12)))
    scene.add_surface("table", table, scene.material("oak", (0.45, 0.29, 0.16), roughness=0.4))
    ball = scene.geometry(sphere(20))
    scene.add_mesh("glass ball", ball, scene.glass("glass", 1.5), (0.02, 0.581, -0.15), 0.12)
    scene.add_mesh("steel ball", ball, scene.metal("steel", (0.7, 0.7, 0.72), 0.15), (-0.45, 0.571, -0.3), 0.11)
    scene.add_mesh("clay ball", ball, scene.diffuse("clay", (0.62, 0.33, 0.22)), (-0.25, 0.531, 0.02), 0.07)


def build():
    scene = Gltf("A room with sun through a window and a skylight", (384, 256), {"spp": 256, "max-depth": 10})
    scene.add_surface("walls", shell(), scene.diffuse("plaster", (0.78, 0.76, 0.72)))
    scene.add_surface("floor", box((-WIDTH / 2 - 0.1, -WALL / 2, -DEPTH / 2 - 0.1), (WIDTH / 2 + 0.1, 0.0, DEPTH / 2 + 0.1)),
                      scene.material("boards", (0.36, 0.25, 0.17), roughness=0.45))
    (z0, y0), (z1, y1) = WINDOW
    # Before the opening and larger than it, two millimetres off the wall: a solid that stands in another is a question of media.
    outside, rim = WIDTH / 2 + WALL + 0.002, 0.1
    scene.add_surface("pane", box((outside, y0 - rim, z0 - rim), (outside + PANE, y1 + rim, z1 + rim)), scene.glass("window glass", 1.52))
    things(scene)
    scene.add_surface("ground", quad((0.0, -WALL - 0.01, 0.0), (0.0, 0.0, 60.0), (60.0, 0.0, 0.0)), scene.diffuse("grass", (0.2, 0.3, 0.12)))
    scene.directional_light(SUN_DIRECTION, SUN, (1.0, 0.93, 0.8))
    scene.environment(SKY)
    scene.perspective_camera(look_at((2.1, 1.55, 1.75), (-0.9, 0.75, -0.7)), math.radians(58.0), 1.5)
    return {"sunlit-room": scene}
