"""A tiled pool under a small sun: every light path to its floor passes the waves, and so does every look at it. The water
is one closed body that reaches a little into walls and floor, so that no gap of air lies between."""
import math

from .gltf import Gltf
from .mesh import Mesh, box, join, quad, sphere
from .solids import arc, disk, height_field, lathe, moved, tilted_frame
from .vec import look_at, normalize, scale

WIDTH, LENGTH, DEPTH = 4.0, 3.0, 1.1  # x, z, and from the water's mean level (y = 0) down
RIM = 0.14                            # of the pool above the water
TILE, GROUT = 0.2, 0.008
TILES = ((0.16, 0.45, 0.60), (0.30, 0.62, 0.72), (0.75, 0.84, 0.86))
WATER_TINT = ((0.45, 0.80, 0.88), 4.0)  # left of white after so many metres
SUN_DIRECTION = normalize((0.45, 0.80, 0.28))  # towards it
SUN_DISTANCE, SUN_HALF_ANGLE = 14.0, math.radians(0.27)  # so near that light paths from it find the pool
SUN_IRRADIANCE = (4.4, 4.0, 3.4)
SKY = (0.22, 0.34, 0.52)
# Waves: amplitude in metres, wave vector in rad/m, phase.
WAVES = ((0.011, (3.1, 1.3), 0.4), (0.008, (-2.2, 4.7), 1.9), (0.0045, (6.5, 5.1), 3.1), (0.0035, (8.9, -4.2), 5.0),
         (0.0022, (-11.3, 8.4), 2.2), (0.0016, (5.2, -15.7), 0.9))
OVERLAP = 0.02  # of the water into what surrounds it


def waves(x, z):
    """Height and slopes of the water."""
    y = slope_x = slope_z = 0.0
    for amplitude, (kx, kz), phase in WAVES:
        angle = kx * x + kz * z + phase
        y += amplitude * math.sin(angle)
        slope_x += amplitude * kx * math.cos(angle)
        slope_z += amplitude * kz * math.cos(angle)
    return y, slope_x, slope_z


def water(columns=160, rows=120):
    """Closed: the wavy top, skirts that follow its edge, a flat bottom."""
    half_x, half_z, bottom = WIDTH / 2 + OVERLAP, LENGTH / 2 + OVERLAP, -DEPTH - OVERLAP
    mesh = height_field(columns, rows, (-half_x, -half_z), (half_x, half_z), waves)
    stride = columns + 1
    edges = [([k for k in range(stride)], (0.0, 0.0, -1.0)),
             ([rows * stride + columns - k for k in range(stride)], (0.0, 0.0, 1.0)),
             ([(rows - k) * stride for k in range(rows + 1)], (-1.0, 0.0, 0.0)),
             ([columns + k * stride for k in range(rows + 1)], (1.0, 0.0, 0.0))]
    for upper, normal in edges:
        first = len(mesh.positions)
        for index in upper:
            x, y, z = mesh.positions[index]
            mesh.positions += [(x, y, z), (x, bottom, z)]
            mesh.normals += [normal] * 2
        for k in range(len(upper) - 1):
            a = first + 2 * k
            mesh.triangles += [(a, a + 2, a + 3), (a, a + 3, a + 1)]
    # The bottom takes the skirts' lower corners, so that no edge of it is met by a corner in between.
    rim = [mesh.positions[i] for upper, _ in edges[:1] for i in upper]
    rim += [mesh.positions[i] for i in edges[3][0][1:]] + [mesh.positions[i] for i in edges[1][0][1:]]
    rim += [mesh.positions[i] for i in edges[2][0][1:-1]]
    first = len(mesh.positions)
    mesh.positions += [(x, bottom, z) for x, _, z in rim] + [(0.0, bottom, 0.0)]
    mesh.normals += [(0.0, -1.0, 0.0)] * (len(rim) + 1)
    mesh.triangles += [(first + k, first + (k + 1) % len(rim), first + len(rim)) for k in range(len(rim))]
    return mesh


def tiled(meshes, corner, u_axis, v_axis, columns, rows, shift):
    """Tiles over a wall from `corner`, dealt out to the meshes by a pattern; their fronts face cross(u, v)."""
    size = TILE - GROUT
    for j in range(rows):
        for i in range(columns):
            u, v = (i + 0.5) * TILE, (j + 0.5) * TILE
            center = tuple(corner[k] + u * u_axis[k] + v * v_axis[k] for k in range(3))
            kind = 2 if (i * 7 + j * 5 + shift) % 11 == 0 else (i + j) % 2
            join(meshes[kind], quad(center, scale(u_axis, size), scale(v_axis, size)))


def pool_walls(scene):
    tiles = [Mesh([], [], []) for _ in TILES]
    grout = Mesh([], [], [])
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    columns, rows, up = round(WIDTH / TILE), round(LENGTH / TILE), math.ceil((DEPTH + RIM) / TILE)
    low, half_x, half_z, high = -DEPTH, WIDTH / 2, LENGTH / 2, -DEPTH + up * TILE
    behind = 0.003  # of the grout
    tiled(tiles, (-half_x, low, -half_z), z, x, rows, columns, 0)
    tiled(tiles, (-half_x, low, -half_z), x, y, columns, up, 3)
    tiled(tiles, (half_x, low, half_z), scale(x, -1.0), y, columns, up, 5)
    tiled(tiles, (-half_x, low, half_z), scale(z, -1.0), y, rows, up, 1)
    tiled(tiles, (half_x, low, -half_z), z, y, rows, up, 8)
    mid = (low + high) / 2
    join(grout, quad((0.0, low - behind, 0.0), (0.0, 0.0, LENGTH), (WIDTH, 0.0, 0.0)))
    for side in (-1.0, 1.0):
        join(grout, quad((0.0, mid, side * (half_z + behind)), (-side * WIDTH, 0.0, 0.0), (0.0, high - low, 0.0)))
        join(grout, quad((side * (half_x + behind), mid, 0.0), (0.0, 0.0, side * LENGTH), (0.0, high - low, 0.0)))
    for mesh, color in zip(tiles, TILES):
        scene.add_surface("tiles", mesh, scene.diffuse("tile", color))
    scene.add_surface("grout", grout, scene.diffuse("grout", (0.62, 0.64, 0.64)))

    # The deck juts out over the tiles: in one plane with them it would be a matter of rounding which is seen.
    deck = Mesh([], [], [])
    edge_x, edge_z, under = half_x - 0.01, half_z - 0.01, high - 0.06
    for low_corner, high_corner in (((-6.0, under, -5.0), (6.0, high, -edge_z)), ((-6.0, under, edge_z), (6.0, high, 5.0)),
                                    ((-6.0, under, -edge_z), (-edge_x, high, edge_z)),
                                    ((edge_x, under, -edge_z), (6.0, high, edge_z))):
        join(deck, box(low_corner, high_corner))
    scene.add_surface("deck", deck, scene.diffuse("stone", (0.66, 0.60, 0.52)))


def toys(scene):
    ball = scene.geometry(sphere(16))
    scene.add_mesh("ball", ball, scene.diffuse("red", (0.75, 0.07, 0.05)), (-0.75, 0.10, -0.45), 0.17)
    ring = lathe([arc((0.16, 0.0), 0.022, 0, 360, 40)], 96)
    axes = tilted_frame((0.12, 1.0, 0.05), (0.0, 0.0, 1.0))
    scene.add_surface("diving ring", moved(ring, *axes, (0.55, -DEPTH + 0.046, 0.35)),
                      scene.diffuse("yellow", (0.85, 0.62, 0.05)))


def sky(scene):
    radius = SUN_DISTANCE * math.tan(SUN_HALF_ANGLE)
    x, y, z = tilted_frame(SUN_DIRECTION, (0.0, 0.0, 1.0))
    solid_angle = math.pi * math.tan(SUN_HALF_ANGLE) ** 2
    scene.add_surface("sun", moved(disk(radius, 32), x, y, z, scale(SUN_DIRECTION, SUN_DISTANCE)),
                      scene.light_material("sun", scale(SUN_IRRADIANCE, 1.0 / solid_angle)))
    scene.add_mesh("sky", scene.geometry(sphere(12).turned_inside_out()), scene.light_material("sky", SKY),
                   (0.0, 0.0, 0.0), SUN_DISTANCE + 1.0)


def build():
    scene = Gltf("A tiled pool under a small sun", (768, 512), {"spp": 512, "max-depth": 12, "merge-radius": "0.02",
                                                   "exposure": -0.7})
    pool_walls(scene)
    scene.add_surface("water", water(), scene.glass("water", 1.33, attenuation=WATER_TINT))
    toys(scene)
    sky(scene)
    scene.perspective_camera(look_at((1.7, 1.75, 2.9), (-0.1, -0.55, -0.1)), math.radians(40.0), 1.5)
    return {"pool": scene}
