"""A scene of a million triangles for benchmarks: a rugged boulder in a lit room. Too large to be committed."""
import math

from .gltf import Gltf
from .mesh import Mesh, box, quad, sphere
from .vec import add, cross, dot, look_at, normalize, scale, sub

FREQUENCY = 224  # 20 * 224^2 = 1,003,520 triangles
OCTAVES = 9


def waves():
    """(direction, frequency, amplitude, phase) of the relief; directions by the golden angle."""
    for k in range(3 * OCTAVES):
        height = 1.0 - 2.0 * (k + 0.5) / (3 * OCTAVES)
        phi = k * math.pi * (3.0 - math.sqrt(5.0))
        ring = math.sqrt(1.0 - height**2)
        frequency = 2.0 * 1.7 ** (k / 3)
        yield (ring * math.cos(phi), ring * math.sin(phi), height), frequency, 0.16 / frequency**0.8, 1.3 * k


def boulder(frequency=FREQUENCY):
    ball = sphere(frequency)
    relief = list(waves())
    positions = []
    for p in ball.positions:
        radius = 1.0 + sum(a * math.sin(f * dot(d, p) + phase) for d, f, a, phase in relief)
        positions.append(scale(p, radius))
    normals = [(0.0, 0.0, 0.0)] * len(positions)
    for triangle in ball.triangles:
        a, b, c = (positions[i] for i in triangle)
        weighted = cross(sub(b, a), sub(c, a))
        for i in triangle:
            normals[i] = add(normals[i], weighted)
    return Mesh(positions, ball.triangles, [normalize(n) for n in normals])


def build():
    scene = Gltf("A boulder of a million triangles", (512, 512), {"spp": 64, "max-depth": 8})
    room = box((-2.0, -1.3, -2.0), (2.0, 2.7, 2.0)).turned_inside_out()
    scene.add_surface("room", room, scene.diffuse("white", (0.7, 0.7, 0.7)))
    scene.add_surface("boulder", boulder(), scene.diffuse("stone", (0.55, 0.5, 0.45)))
    lamp = quad((0.0, 2.69, 0.0), (1.2, 0.0, 0.0), (0.0, 0.0, 1.2))
    scene.add_surface("lamp", lamp, scene.light_material("lamp", (16.0, 15.0, 13.0)))
    scene.perspective_camera(look_at((0.6, 0.9, 1.95), (0.0, 0.0, 0.0)), math.radians(75))
    return scene
