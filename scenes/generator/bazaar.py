"""A hall under 1250 small lamps of 80 triangles each, for benchmarks of many lights. Too large to be committed."""
import math

from .gltf import Gltf
from .mesh import Mesh, box, join, sphere
from .vec import add, look_at, scale

ROWS, COLUMNS = 50, 25
HALL = (10.0, 4.0, 30.0)  # m
COLORS = [(1.0, 0.75, 0.4), (1.0, 0.45, 0.2), (0.6, 0.8, 1.0), (0.9, 0.9, 0.8), (0.5, 1.0, 0.5)]


def lamps(kind):
    """The lamps of one colour, each of another size and height, along the hall."""
    ball = sphere(2)
    all_of_them = Mesh([], [])
    for index in range(kind, ROWS * COLUMNS, len(COLORS)):
        row, column = divmod(index, COLUMNS)
        jitter = [math.modf((index + 1) * step)[0] for step in (0.8191725134, 0.6710436067, 0.5497004779)]
        center = ((column + jitter[0]) * HALL[0] / COLUMNS - 0.5 * HALL[0],
                  0.6 + (HALL[1] - 0.8) * jitter[1] ** 0.5, -(row + jitter[2]) * HALL[2] / ROWS)
        radius = 0.01 * 4.0 ** jitter[2]
        join(all_of_them, Mesh([add(center, scale(p, radius)) for p in ball.positions], ball.triangles))
    return all_of_them


def build(lit):
    """lit: how many triangles of lamps emit; the others are there, but grey. 0: one triangle below the ceiling does."""
    scene = Gltf("A hall of a hundred thousand emitters", (640, 360), {"spp": 64, "max-depth": 6})
    room = box((-0.5 * HALL[0], 0.0, -HALL[2]), (0.5 * HALL[0], HALL[1], 0.0)).turned_inside_out()
    scene.add_surface("hall", room, scene.diffuse("plaster", (0.6, 0.58, 0.55)))
    stone = scene.diffuse("stone", (0.5, 0.4, 0.3))
    for z in range(-27, 0, 3):
        for x in (-2.5, 2.5):
            scene.add_surface("pillar", box((x - 0.2, 0.0, z - 0.2), (x + 0.2, HALL[1], z + 0.2)), stone)
    if lit == 0:
        below = Mesh([(-4.0, 3.9, -2.0), (0.0, 3.9, -28.0), (4.0, 3.9, -2.0)], [(0, 1, 2)])
        scene.add_surface("ceiling light", below, scene.light_material("lamp", (3.0, 3.0, 3.0)))
    grey = scene.diffuse("grey", (0.4, 0.4, 0.4))
    for kind, color in enumerate(COLORS):
        mesh = lamps(kind)
        count = min(lit, len(mesh.triangles))
        lit -= count
        for part, name, material in ((mesh.triangles[:count], "lamps", scene.light_material("lamp", scale(color, 60.0))),
                                     (mesh.triangles[count:], "dark lamps", grey)):
            if part:
                scene.add_surface(name, Mesh(mesh.positions, part), material)
    scene.perspective_camera(look_at((0.6, 1.7, -0.5), (0.0, 1.4, -12.0)), math.radians(60), 16 / 9)
    return scene
