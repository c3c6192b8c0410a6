"""Triangle meshes. The front face, from which vertices run counter-clockwise, is the side that a surface
shows to the scene: outward for solids, towards the room for walls and lights."""
import math
from dataclasses import dataclass, field

from .vec import add, cross, dot, length, normalize, scale, sub


@dataclass
class Mesh:
    """Empty `normals` mean flat shading (the glTF rule for a missing NORMAL attribute)."""
    positions: list
    triangles: list
    normals: list = field(default_factory=list)

    def turned_inside_out(self):
        """The same surface with its front face on the other side."""
        return Mesh(self.positions, [(a, c, b) for a, b, c in self.triangles],
                    [scale(n, -1.0) for n in self.normals])

    def flat(self):
        return Mesh(self.positions, self.triangles)

    def corners(self):
        """Yields the three positions of each triangle."""
        for a, b, c in self.triangles:
            yield self.positions[a], self.positions[b], self.positions[c]

    def area(self):
        return sum(0.5 * length(cross(sub(b, a), sub(c, a))) for a, b, c in self.corners())


def quad(center, edge_u, edge_v):
    """Rectangle spanned by two full edge vectors; its front faces cross(edge_u, edge_v). Flat, with normals."""
    half_u, half_v = scale(edge_u, 0.5), scale(edge_v, 0.5)
    corners = [sub(sub(center, half_u), half_v), sub(add(center, half_u), half_v),
               add(add(center, half_u), half_v), add(sub(center, half_u), half_v)]
    return Mesh(corners, [(0, 1, 2), (0, 2, 3)], [normalize(cross(edge_u, edge_v))] * 4)


def box(low, high):
    """Axis-aligned box, front faces outward, flat normals."""
    center, size = scale(add(low, high), 0.5), sub(high, low)
    mesh = Mesh([], [], [])
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        edge_u = tuple(size[i] if i == u else 0.0 for i in range(3))
        edge_v = tuple(size[i] if i == v else 0.0 for i in range(3))
        offset = tuple(0.5 * size[i] if i == axis else 0.0 for i in range(3))
        join(mesh, quad(add(center, offset), edge_u, edge_v))
        join(mesh, quad(sub(center, offset), edge_v, edge_u))
    return mesh


def join(mesh, other):
    """Appends other to mesh."""
    first = len(mesh.positions)
    mesh.positions.extend(other.positions)
    mesh.normals.extend(other.normals)
    mesh.triangles.extend(tuple(i + first for i in t) for t in other.triangles)


def boxes(*corners):
    """One mesh of boxes, each by its lowest and highest corner."""
    mesh = Mesh([], [], [])
    for low, high in corners:
        join(mesh, box(low, high))
    return mesh


def _icosahedron():
    """Vertices of the regular icosahedron on the unit sphere, a vertex at each pole, and outward faces."""
    ring_height, ring_radius = 1.0 / math.sqrt(5.0), 2.0 / math.sqrt(5.0)
    vertices = [(0.0, 1.0, 0.0)]
    for half_turns, height in ((0.0, ring_height), (0.5, -ring_height)):
        for k in range(5):
            phi = 2.0 * math.pi * (k + half_turns) / 5.0
            vertices.append((ring_radius * math.sin(phi), height, ring_radius * math.cos(phi)))
    vertices.append((0.0, -1.0, 0.0))
    faces = []
    for k in range(5):
        top, top_next, low, low_next = 1 + k, 1 + (k + 1) % 5, 6 + k, 6 + (k + 1) % 5
        faces += [(0, top, top_next), (top, low, top_next), (top_next, low, low_next), (low, 11, low_next)]
    return vertices, faces


def sphere(frequency):
    """Unit geodesic sphere of 20 * frequency^2 nearly equal triangles, smooth normals: no thin triangles at
    the poles, which a sphere of meridians has. Vertices on shared edges exist once (no cracks)."""
    vertices, faces = _icosahedron()
    mesh = Mesh([], [], [])
    index_of = {}

    def vertex(weights):
        """Index of the point with integer barycentric weights {icosahedron vertex: weight > 0}."""
        key = tuple(sorted(weights.items()))
        if key not in index_of:
            point = (0.0, 0.0, 0.0)
            for i, weight in key:
                point = add(point, scale(vertices[i], weight))
            index_of[key] = len(mesh.positions)
            mesh.positions.append(normalize(point))
        return index_of[key]

    for a, b, c in faces:
        rows = [[vertex({i: w for i, w in ((a, frequency - row), (b, row - k), (c, k)) if w})
                 for k in range(row + 1)] for row in range(frequency + 1)]
        for row in range(frequency):
            for k in range(row + 1):
                mesh.triangles.append((rows[row][k], rows[row + 1][k], rows[row + 1][k + 1]))
                if k < row:
                    mesh.triangles.append((rows[row][k], rows[row + 1][k + 1], rows[row][k + 1]))
    mesh.normals = list(mesh.positions)
    return mesh


def facing_facets(mesh, direction):
    """[(area seen from a direction, cosine between normal and direction)] of the triangles that face it."""
    facets = []
    for a, b, c in mesh.corners():
        twice_area_normal = cross(sub(b, a), sub(c, a))
        facing = dot(twice_area_normal, direction)
        if facing > 0.0:
            facets.append((0.5 * facing, facing / length(twice_area_normal)))
    return facets
