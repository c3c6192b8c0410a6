#!/usr/bin/env python3
"""Writes the tilted slabs beside it, and prints what they transmit: the mean over the camera's film of .5^(thickness /
nominal), by rational arithmetic on the floats that the files hold. Along the view a slab of 1e-7 m is one or two floats thick, at
each corner another number of them."""
import base64
import json
import math
import pathlib
import struct
from fractions import Fraction

FRONT, BACK = (4, 5, 6, 7), (3, 2, 1, 0)
FACES = (FRONT, BACK, (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
CAMERA = (0.013, 0.017, 3)  # looks along -z, at a square of side 1
GRID = 24


def as_float(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


def corners(degrees, thickness):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [[as_float(x), as_float(c * y - s * z), as_float(s * y + c * z)] for z in (-thickness / 2, thickness / 2)
            for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]


def triangles(face):
    a, b, c, d = face
    return [(a, b, c), (a, c, d)]


def height(points, face, x, y):
    """z of a face at x, y."""
    for triangle in triangles(face):
        a, b, c = ([Fraction(v) for v in points[i]] for i in triangle)
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        u = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area
        v = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area
        if u >= 0 and v >= 0 and u + v <= 1:
            return a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
    raise ValueError("beside the slab")


def transmitted(points, nominal):
    total = 0
    for i in range(GRID):
        for j in range(GRID):
            x, y = (Fraction(CAMERA[k] + (n + 0.5) / GRID - 0.5) for k, n in ((0, i), (1, j)))
            total += 0.5 ** (float(height(points, FRONT, x, y) - height(points, BACK, x, y)) / nominal)
    return total / GRID**2


def write(name, degrees, thickness, is_reversed=False):
    points = corners(degrees, thickness)
    order = (0, 2, 1) if is_reversed else (0, 1, 2)
    indices = [t[k] for face in FACES for t in triangles(face) for k in order]
    data = b"".join(struct.pack("<3f", *p) for p in points) + struct.pack(f"<{len(indices)}H", *indices)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    volume = {"thicknessFactor": 1, "attenuationDistance": thickness, "attenuationColor": [0.5, 0.5, 0.5]}
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1},
                  "KHR_materials_volume": volume}
    scene = {
        "asset": {"version": "2.0"}, "extensionsUsed": list(extensions), "scene": 0,
        "scenes": [{"nodes": [0, 1], "extras": {"regulus": {"environment": {"color": [1, 1, 1]}}}}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": CAMERA}],
        "cameras": [{"type": "orthographic", "orthographic": {"xmag": 0.5, "ymag": 0.5, "znear": 0.01, "zfar": 100}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0}, "extensions": extensions}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",
             "min": [min(p[k] for p in points) for k in range(3)], "max": [max(p[k] for p in points) for k in range(3)]},
            {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 2 * len(indices)}],
        "buffers": [{"byteLength": len(data), "uri": uri}]}
    (pathlib.Path(__file__).parent / name).write_text(json.dumps(scene) + "\n")
    print(f"{name} {transmitted(points, thickness):.5f}")


write("tilted-17.gltf", 17, 1e-7)
write("tilted-30.gltf", 30, 1e-7)
write("tilted-30-reversed.gltf", 30, 1e-6, is_reversed=True)
