"""Solids by revolution, extrusion and sweep. Curved parts have smooth normals, edges are sharp: a profile is a list of
pieces, and normals are shared within a piece only, positions across all of them (no cracks)."""
import math

from .mesh import Mesh
from .vec import add, cross, dot, normalize, scale, sub


def line(start, end):
    """Straight piece of a profile: points (r, y) with the normal to the right of the way."""
    dr, dy = end[0] - start[0], end[1] - start[1]
    size = math.hypot(dr, dy)
    normal = (dy / size, -dr / size)
    return [(start, normal), (end, normal)]


def arc(center, radius, start, end, steps, radius_y=None):
    """Piece of a circle (or ellipse with half height radius_y) from angle start to end, in degrees from +r towards +y.
    Going up in angle, normals point outwards."""
    ry = radius if radius_y is None else radius_y
    side = 1.0 if end > start else -1.0
    piece = []
    for k in range(steps + 1):
        angle = math.radians(start + (end - start) * k / steps)
        c, s = math.cos(angle), math.sin(angle)
        size = math.hypot(ry * c, radius * s)
        piece.append(((center[0] + radius * c, center[1] + ry * s), (side * ry * c / size, side * radius * s / size)))
    return piece


def lathe(pieces, segments):
    """Surface of revolution about y of pieces of a profile. Its front is the side the normals point to: with the axis on
    the left, outside of a profile that runs upwards."""
    mesh = Mesh([], [], [])
    ring = [(math.cos(2.0 * math.pi * k / segments), math.sin(2.0 * math.pi * k / segments)) for k in range(segments)]
    for piece in pieces:
        first = len(mesh.positions)
        for (r, y), (nr, ny) in piece:
            r = 0.0 if abs(r) < 1e-12 else r
            for c, s in ring:
                mesh.positions.append((r * c, y, -r * s))
                mesh.normals.append((nr * c, ny, -nr * s))
        for i in range(len(piece) - 1):
            for k in range(segments):
                a, b = first + i * segments + k, first + i * segments + (k + 1) % segments
                c, d = a + segments, b + segments
                if piece[i][0][0] > 1e-12:
                    mesh.triangles.append((a, b, d))
                if piece[i + 1][0][0] > 1e-12:
                    mesh.triangles.append((a, d, c))
    return mesh


def prism(outline, low, high, bevel=0.0):
    """Upright prism over a convex outline of points (x, z), counter-clockwise seen from above; flat sides. With a bevel its
    top shrinks towards the outline's centre by that share, which makes it a faceted bar."""
    count = len(outline)
    center = (sum(p[0] for p in outline) / count, sum(p[1] for p in outline) / count)
    top = [(x + bevel * (center[0] - x), z + bevel * (center[1] - z)) for x, z in outline]
    mesh = Mesh([], [])
    lower, upper = [(x, low, z) for x, z in outline], [(x, high, z) for x, z in top]
    _flat_fan(mesh, upper)
    _flat_fan(mesh, lower[::-1])
    for k in range(count):
        n = (k + 1) % count
        _flat_fan(mesh, [lower[k], lower[n], upper[n], upper[k]])
    return mesh


def ridged(outline, low, high):
    """A convex outline that rises to a ridge between its first and its third corner (of four): a dauphine hand."""
    a, b, c, d = ((x, low, z) for x, z in outline)
    ridge = [((p[0] + 0.08 * (q[0] - p[0])), high, p[2] + 0.08 * (q[2] - p[2])) for p, q in ((a, c), (c, a))]
    mesh = Mesh([], [])
    for face in ((a, b, ridge[0]), (b, ridge[1], ridge[0]), (b, c, ridge[1]), (c, d, ridge[1]),
                 (d, ridge[0], ridge[1]), (d, a, ridge[0]), (d, c, b, a)):
        _flat_fan(mesh, list(face))
    return mesh


def _flat_fan(mesh, corners):
    first = len(mesh.positions)
    mesh.positions.extend(corners)
    mesh.triangles.extend((first, first + k, first + k + 1) for k in range(1, len(corners) - 1))


def sweep(path, half_width, thickness):
    """A band along a path of points (x, y), thickness to its left, from -half_width to half_width in z (a function of the
    share of the way). Closed; flat sides, smooth along the path."""
    count = len(path)
    normals = []
    for k in range(count):
        p, q = path[max(k - 1, 0)], path[min(k + 1, count - 1)]
        dx, dy = q[0] - p[0], q[1] - p[1]
        size = math.hypot(dx, dy)
        normals.append((-dy / size, dx / size))
    widths = [half_width(k / (count - 1)) for k in range(count)]

    def corner(k, is_upper, side):
        (x, y), (nx, ny) = path[k], normals[k]
        lift = thickness if is_upper else 0.0
        return (x + lift * nx, y + lift * ny, side * widths[k])

    mesh = Mesh([], [], [])
    sides = [(True, 1, True, -1, lambda n: (n[0], n[1], 0.0)), (False, -1, False, 1, lambda n: (-n[0], -n[1], 0.0)),
             (False, 1, True, 1, lambda n: (0.0, 0.0, 1.0)), (True, -1, False, -1, lambda n: (0.0, 0.0, -1.0))]
    for upper_a, side_a, upper_b, side_b, normal_of in sides:
        first = len(mesh.positions)
        for k in range(count):
            mesh.positions += [corner(k, upper_a, side_a), corner(k, upper_b, side_b)]
            mesh.normals += [normal_of(normals[k])] * 2
        for k in range(count - 1):
            a, b, c, d = (first + 2 * k + i for i in range(4))
            mesh.triangles += [(a, c, d), (a, d, b)]
    for k, sign in ((0, -1.0), (count - 1, 1.0)):
        tangent = (normals[k][1] * sign, -normals[k][0] * sign, 0.0)
        first = len(mesh.positions)
        corners = [corner(k, False, 1), corner(k, False, -1), corner(k, True, -1), corner(k, True, 1)]
        mesh.positions += corners if sign > 0 else corners[::-1]
        mesh.normals += [tangent] * 4
        mesh.triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return mesh


def height_field(columns, rows, low, high, surface):
    """The part of y = surface(x, z) -> (y, slope_x, slope_z) over the rectangle from low to high, front up, smooth."""
    mesh = Mesh([], [], [])
    for j in range(rows + 1):
        for i in range(columns + 1):
            x = low[0] + (high[0] - low[0]) * i / columns
            z = low[1] + (high[1] - low[1]) * j / rows
            y, slope_x, slope_z = surface(x, z)
            mesh.positions.append((x, y, z))
            mesh.normals.append(normalize((-slope_x, 1.0, -slope_z)))
    for j in range(rows):
        for i in range(columns):
            a = j * (columns + 1) + i
            b, c, d = a + 1, a + columns + 1, a + columns + 2
            mesh.triangles += [(a, c, d), (a, d, b)]
    return mesh


def moved(mesh, x_axis, y_axis, z_axis, origin):
    """The mesh in another orthonormal frame."""
    def turn(v):
        return add(add(scale(x_axis, v[0]), scale(y_axis, v[1])), scale(z_axis, v[2]))
    return Mesh([add(turn(p), origin) for p in mesh.positions], list(mesh.triangles), [turn(n) for n in mesh.normals])


def turned_about_y(mesh, degrees, origin=(0.0, 0.0, 0.0)):
    """Counter-clockwise seen from above."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return moved(mesh, (c, 0.0, -s), (0.0, 1.0, 0.0), (s, 0.0, c), origin)


def disk(radius, corners):
    """Flat disk about the y axis; its front faces -y."""
    rim = [(radius * math.cos(a), 0.0, radius * math.sin(a)) for a in (2 * math.pi * k / corners for k in range(corners))]
    return Mesh(rim, [(0, k, k + 1) for k in range(1, corners - 1)], [(0.0, -1.0, 0.0)] * corners)


def tilted_frame(y_axis, towards):
    """Orthonormal axes with the given y axis and z axis near `towards`."""
    y = normalize(y_axis)
    z = normalize(sub(towards, scale(y, dot(towards, y))))
    return cross(y, z), y, z
