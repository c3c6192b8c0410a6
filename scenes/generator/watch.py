"""A wristwatch of true size under a domed sapphire crystal, lit by small bright lamps. Everything on the dial is lit
through the crystal and seen through it: light that only paths with specular, diffuse, specular events carry."""
import math

from .gltf import Gltf
from .mesh import Mesh, join, quad
from .solids import arc, disk, lathe, line, moved, prism, ridged, sweep, tilted_frame, turned_about_y
from .vec import add, look_at, normalize, scale

MM = 0.001
DIAL_Y, DIAL_RADIUS = 5.6, 16.4  # lengths in mm, until the meshes are scaled
PRINT = 0.015                    # height of printing above the dial
TIME = (10, 8, 36.0)             # hours, minutes, seconds on the small dial
STEEL, GOLD, NAVY = (0.66, 0.65, 0.64), (0.93, 0.72, 0.42), (0.016, 0.048, 0.16)
SUBDIAL = (0.0, 8.0, 4.3)        # centre x, z (6 o'clock is +z) and radius
# Centre and radius (m) and radiance of the lamps: disks that shine at the watch.
LAMPS = (((-0.11, 0.20, -0.06), 0.006, (2400.0, 2200.0, 1950.0)), ((0.14, 0.17, -0.10), 0.005, (1500.0, 1650.0, 1900.0)),
         ((0.04, 0.24, 0.14), 0.004, (1200.0, 1100.0, 1000.0)))
# Centre and edges (m) and radiance of dim panels that metal mirrors; fronts towards the watch. The first two stand so low
# that the crystal does not show them, the third makes a faint veil on it.
PANELS = (((-0.32, 0.075, 0.0), (0.0, 0.15, 0.0), (0.0, 0.0, 0.5), (0.6, 0.62, 0.66)),
          ((0.0, 0.075, -0.42), (0.6, 0.0, 0.0), (0.0, 0.15, 0.0), (0.6, 0.62, 0.66)),
          ((0.0, 0.50, -0.26), (0.5, 0.0, 0.0), (0.0, 0.12, 0.24), (0.16, 0.17, 0.19)))


def in_metres(mesh):
    return Mesh([scale(p, MM) for p in mesh.positions], mesh.triangles, mesh.normals)


def bar(angle, near, far, half_width, low, high, bevel=0.0):
    """A bar on the dial along the ray at `angle` degrees clockwise from 12 o'clock, between two radii."""
    outline = [(-half_width, -far), (-half_width, -near), (half_width, -near), (half_width, -far)]
    return turned_about_y(prism(outline, low, high, bevel), -angle)


def mark(angle, near, far, half_width, center=(0.0, 0.0)):
    """A printed stroke like bar()."""
    stroke = quad((0.0, DIAL_Y + PRINT, -(near + far) / 2), (2 * half_width, 0.0, 0.0), (0.0, 0.0, -(far - near)))
    return turned_about_y(stroke, -angle, (center[0], 0.0, center[1]))


def case(scene):
    """Brushed flank, polished back and bezel, polished slope down to the dial; together they are closed."""
    flank = lathe([line((20.0, 2.2), (20.0, 6.0))], 192)
    foot, bezel = arc((18.2, 2.9), 1.8, -90, -23, 10), arc((18.3, 6.7), 1.3, 0, 90, 14)
    polished = lathe([line((0.0, 0.9), (16.0, 0.9)), line((16.0, 0.9), foot[0][0]), foot, line(foot[-1][0], (20.0, 2.2)),
                      line((20.0, 6.0), (19.6, 6.3)), line((19.6, 6.3), bezel[0][0]), bezel,
                      line(bezel[-1][0], (17.45, 8.0)), line((17.45, 8.0), (17.45, 6.9))], 192)
    slope = lathe([line((17.45, 6.9), (16.9, 6.9)), line((16.9, 6.9), (16.0, 5.2)), line((16.0, 5.2), (0.0, 5.2))], 192)
    scene.add_surface("flank", in_metres(flank), scene.metal("brushed steel", STEEL, 0.38))
    scene.add_surface("case", in_metres(polished), scene.metal("polished steel", STEEL, 0.0))
    scene.add_surface("slope", in_metres(slope), scene.metal("satin steel", STEEL, 0.3))

    lugs = Mesh([], [])
    for x in (-11.6, 11.6):
        for side in (-1.0, 1.0):
            # The prism lies on its side: its height runs across the lug, its outline is the lug seen from the side.
            profile = [(15.2, 5.9), (15.2, 2.0), (22.0, 0.6), (24.4, 0.7), (24.4, 1.8), (20.5, 5.2)]
            corners = [(side * z, y) for z, y in profile]
            lug = prism([(p[0], p[1]) for p in (corners if side < 0 else corners[::-1])], x - 1.4, x + 1.4)
            join(lugs, moved(lug, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)).flat())
    scene.add_surface("lugs", in_metres(lugs), scene.metal("satin steel", STEEL, 0.3))

    knurls = []
    for k in range(80):
        radius = 2.6 if k % 4 < 2 else 2.35
        knurls.append((radius * math.cos(2 * math.pi * k / 80), radius * math.sin(2 * math.pi * k / 80)))
    crown = _star_prism(knurls, 0.0, 2.6)
    stem = lathe([line((0.0, -0.5), (1.6, -0.5)), line((1.6, -0.5), (1.6, 0.0)), line((1.6, 0.0), (0.0, 0.0))], 48)
    cap = lathe([line((0.0, 2.6), (2.1, 2.6)), arc((0.0, 2.6), 2.1, 0, 90, 48, 0.9)], 48)
    frame = ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0))
    steel = scene.metal("polished steel", STEEL, 0.12)
    for name, part in (("crown", crown), ("stem", stem), ("crown cap", cap)):
        scene.add_surface(name, in_metres(moved(part, *frame, (20.4, 4.1, 0.0))), steel)


def _star_prism(outline, low, high):
    """Upright prism over an outline (x, z) that is star-shaped about the axis, counter-clockwise seen from above."""
    mesh = Mesh([], [])
    count = len(outline)
    outline = outline[::-1]
    for k in range(count):
        (ax, az), (bx, bz) = outline[k], outline[(k + 1) % count]
        first = len(mesh.positions)
        mesh.positions += [(0.0, high, 0.0), (ax, high, az), (bx, high, bz), (0.0, low, 0.0), (ax, low, az), (bx, low, bz)]
        mesh.triangles += [(first, first + 1, first + 2), (first + 3, first + 5, first + 4),
                           (first + 4, first + 5, first + 2), (first + 4, first + 2, first + 1)]
    return mesh


def crystal(scene):
    """A dome of even thickness on a cylindrical foot, 0.05 mm clear of the bezel."""
    radius, foot, shoulder, thickness = 17.4, 7.0, 8.3, 1.3
    rise = 2.6
    outer = (radius * radius + rise * rise) / (2 * rise)  # sphere through the shoulder that rises above it
    inner, inner_radius = outer - thickness, radius - 1.6
    center = shoulder + rise - outer
    end = math.degrees(math.asin((shoulder - center) / outer))
    inner_end = math.degrees(math.acos(inner_radius / inner))
    inner_shoulder = center + inner * math.sin(math.radians(inner_end))
    # The ends of the arcs, as the arcs compute them.
    edge = (outer * math.cos(math.radians(end)), center + outer * math.sin(math.radians(end)))
    inner_edge = (inner * math.cos(math.radians(inner_end)), inner_shoulder)
    pieces = [line((edge[0], foot), edge), arc((0.0, center), outer, end, 90.0, 40),
              arc((0.0, center), inner, 90.0, inner_end, 40), line(inner_edge, (inner_edge[0], foot)),
              line((inner_edge[0], foot), (edge[0], foot))]
    scene.add_surface("crystal", in_metres(lathe(pieces, 192)), scene.glass("sapphire", 1.77))


def dial(scene):
    scene.add_surface("dial", in_metres(lathe([line((16.3, DIAL_Y - 0.3), (16.3, DIAL_Y)), line((16.3, DIAL_Y), (0.0, DIAL_Y))], 192)),
                      scene.material("blue lacquer", NAVY, roughness=0.22))
    printing = Mesh([], [], [])
    for k in range(60):
        near = 14.7 if k % 5 else 14.2
        join(printing, mark(6.0 * k, near, 15.6, 0.055 if k % 5 else 0.14))
        for fifth in range(1, 5):
            join(printing, mark(6.0 * k + 1.2 * fifth, 15.2, 15.6, 0.03))
    x, z, radius = SUBDIAL
    for k in range(60):
        join(printing, mark(6.0 * k, radius - (0.5 if k % 5 else 1.0), radius - 0.15, 0.035 if k % 5 else 0.07, (x, z)))
    for strokes, (letter_x, letter_z), size in lettering("REGULUS", (0.0, -8.3), 1.15) + lettering("AUTOMATIC", (0.0, -6.1), 0.55):
        for start, end in strokes:
            join(printing, _stroke((letter_x + size * start[0], letter_z + size * start[1]),
                                   (letter_x + size * end[0], letter_z + size * end[1]), 0.11 * size))
    scene.add_surface("printing", in_metres(printing), scene.diffuse("white ink", (0.82, 0.82, 0.80)))

    gold = scene.metal("polished gold", GOLD, 0.0)
    indices = Mesh([], [])
    for hour in range(12):
        if hour == 6:
            continue  # the small seconds stand there
        offsets = (-3.2, 3.2) if hour == 0 else (0.0,)
        for offset in offsets:
            join(indices, bar(30.0 * hour + offset, 10.2, 13.7, 0.42, DIAL_Y + 0.005, DIAL_Y + 0.6, 0.3).flat())
    scene.add_surface("indices", in_metres(indices), gold)
    scene.add_surface("rim of the small dial",
                      in_metres(turned_about_y(lathe([arc((radius, 0.0), 0.14, 0, 360, 40)], 96), 0.0, (x, DIAL_Y + 0.05, z))), gold)


# Strokes of capital letters on a grid one wide and 1.4 high: ((x, y), (x, y)), y downwards from the top.
LETTERS = {
    "R": (((0, 0), (0, 1.4)), ((0, 0), (0.8, 0)), ((0.8, 0), (0.8, 0.7)), ((0.8, 0.7), (0, 0.7)), ((0.3, 0.7), (0.8, 1.4))),
    "E": (((0, 0), (0, 1.4)), ((0, 0), (0.8, 0)), ((0, 0.7), (0.65, 0.7)), ((0, 1.4), (0.8, 1.4))),
    "G": (((0.8, 0), (0, 0)), ((0, 0), (0, 1.4)), ((0, 1.4), (0.8, 1.4)), ((0.8, 1.4), (0.8, 0.75)), ((0.8, 0.75), (0.45, 0.75))),
    "U": (((0, 0), (0, 1.4)), ((0, 1.4), (0.8, 1.4)), ((0.8, 1.4), (0.8, 0))),
    "L": (((0, 0), (0, 1.4)), ((0, 1.4), (0.8, 1.4))),
    "S": (((0.8, 0), (0, 0)), ((0, 0), (0, 0.7)), ((0, 0.7), (0.8, 0.7)), ((0.8, 0.7), (0.8, 1.4)), ((0.8, 1.4), (0, 1.4))),
    "A": (((0, 1.4), (0.4, 0)), ((0.4, 0), (0.8, 1.4)), ((0.15, 0.9), (0.65, 0.9))),
    "T": (((0, 0), (0.8, 0)), ((0.4, 0), (0.4, 1.4))),
    "O": (((0, 0), (0.8, 0)), ((0.8, 0), (0.8, 1.4)), ((0.8, 1.4), (0, 1.4)), ((0, 1.4), (0, 0))),
    "M": (((0, 1.4), (0, 0)), ((0, 0), (0.4, 0.8)), ((0.4, 0.8), (0.8, 0)), ((0.8, 0), (0.8, 1.4))),
    "I": (((0.4, 0), (0.4, 1.4)),),
    "C": (((0.8, 0), (0, 0)), ((0, 0), (0, 1.4)), ((0, 1.4), (0.8, 1.4))),
}
ADVANCE = 1.2


def lettering(text, center, size):
    """[(strokes, upper left corner, size)] of the letters of a centred line."""
    left = center[0] - size * (ADVANCE * (len(text) - 1) + 0.8) / 2
    return [(LETTERS[letter], (left + size * ADVANCE * k, center[1]), size) for k, letter in enumerate(text)]


def _stroke(start, end, half_width):
    dx, dz = end[0] - start[0], end[1] - start[1]
    size = math.hypot(dx, dz)
    along = (dx * (1 + 2 * half_width / size), 0.0, dz * (1 + 2 * half_width / size))
    across = (dz / size * 2 * half_width, 0.0, -dx / size * 2 * half_width)
    return quad(((start[0] + end[0]) / 2, DIAL_Y + PRINT, (start[1] + end[1]) / 2), along, across)


def hands(scene):
    hours, minutes, seconds = TIME
    gold = scene.metal("polished gold", GOLD, 0.0)
    parts = Mesh([], [])
    for angle, reach, half_width, low in ((30.0 * (hours + minutes / 60.0), 9.2, 0.95, 6.35), (6.0 * minutes, 14.0, 0.8, 6.75)):
        outline = [(0.0, 1.9), (half_width, 0.0), (0.0, -reach), (-half_width, 0.0)]
        join(parts, turned_about_y(ridged(outline, low, low + 0.28), -angle).flat())
    x, z, radius = SUBDIAL
    small = prism([(-0.07, -(radius - 0.7)), (-0.16, 1.0), (0.16, 1.0), (0.07, -(radius - 0.7))], DIAL_Y + 0.35, DIAL_Y + 0.47)
    join(parts, turned_about_y(small, -6.0 * seconds, (x, 0.0, z)).flat())
    scene.add_surface("hands", in_metres(parts), gold)
    for name, center, r, low, high in (("pinion", (0.0, 0.0), 0.62, DIAL_Y, 7.25), ("small pinion", (x, z), 0.32, DIAL_Y, DIAL_Y + 0.7)):
        cap = lathe([line((0.0, low), (r, low)), line((r, low), (r, high - 0.2)), arc((r - 0.2, high - 0.2), 0.2, 0, 90, 12),
                     line((r - 0.2, high), (0.0, high))], 64)
        scene.add_surface(name, in_metres(turned_about_y(cap, 0.0, (center[0], 0.0, center[1]))), gold)


def strap(scene):
    """Leather that leaves the lugs and lies down on the table."""
    leather = scene.material("leather", (0.16, 0.065, 0.03), roughness=0.55)
    for side in (1.0, -1.0):
        path = [(22.6, 1.0)]
        for k in range(1, 41):
            s = k / 40.0
            path.append((22.6 + 78.0 * s, 0.05 + 0.95 * (1 - s) ** 4))
        band = sweep(path, lambda s: 10.0 - 1.6 * min(1.0, s), 2.2)
        # The sweep runs along x; the strap along z, to both sides.
        axes = ((0.0, 0.0, side), (0.0, 1.0, 0.0), (-side, 0.0, 0.0))
        scene.add_surface("strap", in_metres(moved(band, *axes, (0.0, 0.0, 0.0))), leather)


def surroundings(scene):
    scene.add_surface("table", quad((0.0, 0.0, 0.0), (0.0, 0.0, 1.6), (1.6, 0.0, 0.0)),
                      scene.material("slate", (0.13, 0.125, 0.12), roughness=0.6))
    for number, (center, radius, radiance) in enumerate(LAMPS, 1):
        lamp = moved(disk(radius, 32), *tilted_frame(center, (0.0, 0.0, 1.0)), center)
        scene.add_surface(f"lamp {number}", lamp, scene.light_material(f"lamp {number}", radiance))
    for number, (center, u, v, radiance) in enumerate(PANELS, 1):
        scene.add_surface(f"panel {number}", quad(center, u, v), scene.light_material(f"panel {number}", radiance))


def build():
    scene = Gltf("A wristwatch under a domed crystal", (768, 768), {"spp": 1024, "max-depth": 12, "merge-radius": "0.0008"})
    case(scene)
    dial(scene)
    hands(scene)
    crystal(scene)
    strap(scene)
    surroundings(scene)
    eye = add((0.0, 0.006, 0.002), scale(normalize((-0.22, 0.86, 0.46)), 0.125))
    scene.perspective_camera(look_at(eye, (0.0005, 0.004, 0.001)), math.radians(24.0))
    return {"watch": scene}
