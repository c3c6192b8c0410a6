"""A closed room lit by two lamps whose filaments sit inside glass: a frosted globe on the table and a clear bulb above it.
No light can be connected to: all of it has passed two glass boundaries."""
import math

from .gltf import Gltf
from .mesh import Mesh, box, join, quad, sphere
from .solids import arc, lathe, line, turned_about_y
from .vec import look_at

HALF_X, HEIGHT, HALF_Z = 1.5, 2.2, 1.4
WALL, FLOOR, ACCENT, WOOD = (0.74, 0.70, 0.63), (0.36, 0.24, 0.15), (0.20, 0.36, 0.38), (0.42, 0.26, 0.14)
TABLE_TOP, TABLE_THICKNESS = 0.74, 0.04
GLOBE, GLOBE_RADIUS, GLOBE_WALL, FROST = (-0.42, 1.02, -0.35), 0.13, 0.005, 0.35
BULB, BULB_RADIUS, BULB_WALL = (0.38, 1.50, -0.25), 0.075, 0.002
FILAMENT_RADIUS = 0.012
GLOBE_RADIANCE, BULB_RADIANCE = (2600.0, 2050.0, 1350.0), (1500.0, 1050.0, 560.0)


def shell(frequency, radius, thickness):
    """A hollow ball of glass: its inner surface faces the hollow."""
    ball = sphere(frequency)
    mesh = Mesh([], [], [])
    for r, surface in ((radius, ball), (radius - thickness, ball.turned_inside_out())):
        join(mesh, Mesh([(r * x, r * y, r * z) for x, y, z in surface.positions], surface.triangles, surface.normals))
    return mesh


def room(scene):
    x, y, z = (2 * HALF_X, 0.0, 0.0), (0.0, HEIGHT, 0.0), (0.0, 0.0, 2 * HALF_Z)
    walls = Mesh([], [], [])
    join(walls, quad((0.0, HEIGHT / 2, HALF_Z), y, x))
    join(walls, quad((0.0, HEIGHT, 0.0), x, z))
    join(walls, quad((-HALF_X, HEIGHT / 2, 0.0), y, z))
    join(walls, quad((HALF_X, HEIGHT / 2, 0.0), z, y))
    scene.add_surface("walls", walls, scene.diffuse("plaster", WALL))
    scene.add_surface("back wall", quad((0.0, HEIGHT / 2, -HALF_Z), x, y), scene.diffuse("painted plaster", ACCENT))
    scene.add_surface("floor", quad((0.0, 0.0, 0.0), z, x), scene.material("boards", FLOOR, roughness=0.5))


def furniture(scene):
    wood = scene.material("wood", WOOD, roughness=0.4)
    table = box((-0.95, TABLE_TOP - TABLE_THICKNESS, -0.75), (0.95, TABLE_TOP, 0.25))
    for leg_x in (-0.88, 0.82):
        for leg_z in (-0.68, 0.12):
            join(table, box((leg_x, 0.001, leg_z), (leg_x + 0.06, TABLE_TOP - TABLE_THICKNESS - 0.001, leg_z + 0.06)))
    scene.add_surface("table", table, wood)
    frame, inner = Mesh([], [], []), Mesh([], [], [])
    for low, high in (((0.15, 1.15, 0.0), (1.05, 1.19, 0.03)), ((0.15, 1.71, 0.0), (1.05, 1.75, 0.03)),
                      ((0.15, 1.191, 0.0), (0.19, 1.709, 0.03)), ((1.01, 1.191, 0.0), (1.05, 1.709, 0.03))):
        join(frame, box((low[0], low[1], -HALF_Z + 0.001), (high[0], high[1], -HALF_Z + high[2])))
    join(inner, quad((0.6, 1.45, -HALF_Z + 0.012), (0.82, 0.0, 0.0), (0.0, 0.52, 0.0)))
    scene.add_surface("mirror frame", frame, wood)
    scene.add_surface("mirror", inner, scene.metal("mirror", (0.92, 0.93, 0.93), 0.0))


def objects(scene):
    belly, neck = arc((0.0, 0.10), 0.09, -60, 50, 32, 0.115), ((0.050, 0.20), (0.066, 0.235), (0.060, 0.235))
    foot, shoulder = belly[0][0], belly[-1][0]
    vase = lathe([line((0.0, foot[1]), foot), belly, line(shoulder, neck[0]), line(neck[0], neck[1]), line(neck[1], neck[2]),
                  line(neck[2], (0.044, 0.19)), line((0.044, 0.19), (0.0, 0.19))], 96)
    scene.add_surface("vase", turned_about_y(vase, 0.0, (0.02, TABLE_TOP + 0.0005, -0.42)),
                      scene.material("glaze", (0.62, 0.12, 0.08), roughness=0.15))
    books = Mesh([], [], [])
    for k, (width, depth, angle) in enumerate(((0.26, 0.19, 8.0), (0.23, 0.17, -11.0))):
        low = 0.0005 + 0.0365 * k
        join(books, turned_about_y(box((-width / 2, low, -depth / 2), (width / 2, low + 0.036, depth / 2)), angle,
                                   (0.42, TABLE_TOP, -0.18)))
    scene.add_surface("books", books, scene.diffuse("cloth", (0.15, 0.22, 0.45)))


def lamps(scene):
    brass = scene.metal("brass", (0.87, 0.70, 0.38), 0.25)
    clear, frosted = scene.glass("clear glass", 1.5), scene.glass("frosted glass", 1.5, FROST)
    foot = lathe([line((0.0, 0.0), (0.085, 0.0)), arc((0.085, 0.008), 0.008, -90, 90, 20), line((0.085, 0.016), (0.016, 0.022)),
                  line((0.016, 0.022), (0.014, 0.13)), line((0.014, 0.13), (0.045, 0.14)), line((0.045, 0.14), (0.045, 0.145)),
                  line((0.045, 0.145), (0.0, 0.145))], 96)
    scene.add_surface("foot", turned_about_y(foot, 0.0, (GLOBE[0], TABLE_TOP + 0.0005, GLOBE[2])), brass)
    cord = lathe([line((0.0, 0.0), (0.016, 0.0)), line((0.016, 0.0), (0.016, 0.05)), line((0.016, 0.05), (0.003, 0.056)),
                  line((0.003, 0.056), (0.003, HEIGHT - BULB[1] - BULB_RADIUS - 0.003)),
                  line((0.003, HEIGHT - BULB[1] - BULB_RADIUS - 0.003), (0.0, HEIGHT - BULB[1] - BULB_RADIUS - 0.003))], 48)
    scene.add_surface("holder", turned_about_y(cord, 0.0, (BULB[0], BULB[1] + BULB_RADIUS + 0.001, BULB[2])), brass)
    scene.add_mesh("globe", scene.geometry(shell(20, GLOBE_RADIUS, GLOBE_WALL)), frosted, GLOBE)
    scene.add_mesh("bulb", scene.geometry(shell(20, BULB_RADIUS, BULB_WALL)), clear, BULB)
    filament = scene.geometry(sphere(12))
    scene.add_mesh("light of the globe", filament, scene.light_material("filament of the globe", GLOBE_RADIANCE), GLOBE,
                   FILAMENT_RADIUS)
    scene.add_mesh("light of the bulb", filament, scene.light_material("filament of the bulb", BULB_RADIANCE), BULB,
                   FILAMENT_RADIUS)


def build():
    scene = Gltf("Lamps of frosted and clear glass in a closed room", (768, 512), {"spp": 1024, "max-depth": 16})
    room(scene)
    furniture(scene)
    objects(scene)
    lamps(scene)
    scene.perspective_camera(look_at((-0.25, 1.35, 1.3), (0.0, 1.02, -0.5)), math.radians(52.0), 1.5)
    return {"lamp": scene}
