"""A ball for every feature of a material, on three steps in a small studio:
front   metal polished and brushed (anisotropic), clear, frosted and tinted glass
middle  matt, plastic, clearcoat, relief by a normal map, colours of vertices
back    thin-walled, masked around a glowing core, blended, glowing, unlit"""
import math
import struct
import zlib

from .gltf import Gltf
from .mesh import Mesh, join, quad, sphere
from .vec import look_at

RADIUS, SPACING, STEP_DEPTH, STEP_HEIGHT = 0.1, 0.26, 0.27, 0.16
COLUMNS, ROWS = 96, 48  # of a ball with texture coordinates
MAP_SIZE = 64


def uv_ball():
    """Unit ball of meridians with texture coordinates and tangents along its parallels."""
    mesh, uvs = Mesh([], [], []), []
    for row in range(ROWS + 1):
        theta = math.pi * row / ROWS
        for column in range(COLUMNS + 1):
            phi = 2 * math.pi * (column % COLUMNS) / COLUMNS
            s = 0.0 if row in (0, ROWS) else math.sin(theta)
            mesh.positions.append((s * math.sin(phi), math.cos(theta), s * math.cos(phi)))
            uvs.append((column / COLUMNS, row / ROWS))
    for row in range(ROWS):
        for column in range(COLUMNS):
            a = row * (COLUMNS + 1) + column
            b = a + COLUMNS + 1
            if row > 0:
                mesh.triangles.append((a, b, a + 1))
            if row < ROWS - 1:
                mesh.triangles.append((a + 1, b, b + 1))
    mesh.normals = list(mesh.positions)
    return mesh, uvs


def png(width, height, channels, rows):
    """8-bit PNG of stored rows, so that its bytes depend on no compressor. channels: 2 grey and alpha, 3 RGB."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    raw = b"".join(b"\0" + bytes(row) for row in rows)
    stored = b"\x78\x01"
    for first in range(0, len(raw), 65535):
        block = raw[first:first + 65535]
        stored += struct.pack("<BHH", first + 65535 >= len(raw), len(block), len(block) ^ 0xFFFF) + block
    stored += struct.pack(">I", zlib.adler32(raw))
    header = struct.pack(">IIBBBBB", width, height, 8, {2: 4, 3: 2}[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", stored) + chunk(b"IEND", b"")


def dimples():
    """Normal map of one hammered dimple, to be repeated."""
    rows = []
    for y in range(MAP_SIZE):
        row = []
        for x in range(MAP_SIZE):
            u, v = 2 * (x + 0.5) / MAP_SIZE - 1, 1 - 2 * (y + 0.5) / MAP_SIZE
            r = math.hypot(u, v)
            slope = 0.75 * math.sin(math.pi * r) if r < 1 else 0.0
            n = (slope * u / r, slope * v / r, 1.0)
            scale = 1 / math.sqrt(n[0] ** 2 + n[1] ** 2 + 1)
            row += [round(127.5 * (1 + c * scale)) for c in n]
        rows.append(row)
    return png(MAP_SIZE, MAP_SIZE, 3, rows)


def holes():
    """White with one round hole in its alpha, to be repeated; the ramp is cut at 1/2."""
    rows = []
    for y in range(MAP_SIZE):
        row = []
        for x in range(MAP_SIZE):
            r = math.hypot(2 * (x + 0.5) / MAP_SIZE - 1, 2 * (y + 0.5) / MAP_SIZE - 1)
            row += [255, max(0, min(255, round(127.5 + 500 * (r - 0.72))))]
        rows.append(row)
    return png(MAP_SIZE, MAP_SIZE, 2, rows)


def bands():
    """Glowing bands, to be repeated from pole to pole."""
    rows = []
    for y in range(MAP_SIZE):
        glow = max(0.0, math.sin(2 * math.pi * (y + 0.5) / MAP_SIZE)) ** 0.5
        rows.append([round(255 * glow ** k) for k in (0.8, 1.4, 2.4)] * 4)
    return png(4, MAP_SIZE, 3, rows)


def hue(t):
    """Soft colour wheel, linear."""
    return tuple(0.08 + 0.8 * (0.5 + 0.5 * math.cos(2 * math.pi * (t - k / 3))) ** 1.5 for k in range(3))


def materials(scene):
    """Rows of materials, front row first."""
    relief = scene.texture(dimples())
    lattice = scene.texture(holes())
    thin = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.5}}
    brushed = scene.material("brushed steel", (0.72, 0.70, 0.68), 1.0, 0.3,
                             extensions={"KHR_materials_anisotropy": {"anisotropyStrength": 0.85}})
    coat = scene.material("car paint", (0.50, 0.02, 0.03), 0.7, 0.45, extensions={
        "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.03}})
    hammered = scene.metal("hammered copper", (0.93, 0.55, 0.40), 0.28)
    scene.amend(hammered, normalTexture={**scene.repeated(relief, 24, 12), "scale": 0.8})
    masked = scene.material("lattice", (0.9, 0.62, 0.2), 1.0, 0.3)
    scene.amend(masked, {"baseColorTexture": scene.repeated(lattice, 16, 8)}, alphaMode="MASK", doubleSided=True)
    blended = scene.material("gauze", (0.25, 0.55, 0.75), 0.0, 0.6)
    scene.amend(blended, {"baseColorFactor": [0.25, 0.55, 0.75, 0.45]}, alphaMode="BLEND", doubleSided=True)
    lamp = scene.material("lamp", (0.02, 0.02, 0.02), roughness=0.3, emission=(4.0, 4.0, 4.0))
    scene.amend(lamp, emissiveTexture=scene.repeated(scene.texture(bands()), 1, 7))
    unlit = scene.material("unlit", (0.95, 0.45, 0.08), extensions={"KHR_materials_unlit": {}})
    return (
        (scene.metal("polished silver", (0.96, 0.95, 0.93), 0.0), brushed, scene.glass("clear glass", 1.5),
         scene.glass("frosted glass", 1.5, 0.35), scene.glass("tinted glass", 1.5, 0.0, ((0.15, 0.75, 0.45), 0.1))),
        (scene.diffuse("plaster", (0.75, 0.72, 0.68)), scene.material("plastic", (0.03, 0.14, 0.55), roughness=0.25), coat,
         hammered, scene.material("vertex colours", (1, 1, 1), roughness=0.4)),
        (scene.material("soap bubble", (0.93, 0.96, 1.0), roughness=0.0, extensions=thin), masked, blended,
         lamp, unlit),
    )


def balls(scene):
    mesh, uvs = uv_ball()
    smooth, few, mapped = scene.geometry(sphere(32)), scene.geometry(sphere(12)), scene.geometry(mesh, uvs)
    colored = {**mapped, "attributes": {**mapped["attributes"], "COLOR_0": scene.colors([hue(u + 0.6 * v) for u, v in uvs])}}
    special = {(0, 1): mapped, (1, 3): mapped, (1, 4): colored, (2, 1): mapped, (2, 3): mapped, (2, 4): few}
    for row, line in enumerate(materials(scene)):
        for column, material in enumerate(line):
            center = ((column - 2) * SPACING, row * STEP_HEIGHT + RADIUS + 0.0002, -row * STEP_DEPTH)
            scene.add_mesh(f"ball {row} {column}", special.get((row, column), smooth), material, center, RADIUS)
    core = (-SPACING, 2 * STEP_HEIGHT + RADIUS, -2 * STEP_DEPTH)
    scene.add_mesh("core", few, scene.light_material("core", (9.0, 5.0, 2.0)), core, 0.035)


def studio(scene):
    steps = Mesh([], [], [])
    width = 1.5
    for row in range(3):
        front = -row * STEP_DEPTH + STEP_DEPTH / 2
        join(steps, quad((0.0, row * STEP_HEIGHT, front - STEP_DEPTH / 2), (0.0, 0.0, STEP_DEPTH), (width, 0.0, 0.0)))
        if row:
            join(steps, quad((0.0, (row - 0.5) * STEP_HEIGHT, front), (width, 0.0, 0.0), (0.0, STEP_HEIGHT, 0.0)))
    stone = scene.material("stone", (0.42, 0.40, 0.38), roughness=0.5)
    scene.add_surface("steps", steps, stone)
    scene.add_surface("floor", quad((0.0, 0.0, STEP_DEPTH / 2 + 1.0), (0.0, 0.0, 2.0), (6.0, 0.0, 0.0)), stone)
    back = scene.diffuse("backdrop", (0.24, 0.29, 0.36))
    scene.add_surface("backdrop", quad((0.0, 1.5, -1.3), (8.0, 0.0, 0.0), (0.0, 4.0, 0.0)), back)
    for name, center, u, v, radiance in (
            ("key", (-1.3, 1.7, 0.9), (0.62, 0.55, -0.45), (0.55, 0.0, 0.75), (15.0, 13.0, 10.8)),
            ("fill", (1.7, 1.1, 0.9), (-0.1, 0.9, 0.0), (0.5, 0.0, -0.7), (2.4, 3.2, 4.6)),
            ("top", (0.0, 2.0, -0.5), (1.6, 0.0, 0.0), (0.0, 0.0, 0.5), (6.0, 6.0, 6.3))):
        scene.add_surface(name, quad(center, u, v), scene.light_material(name, radiance))


def build():
    scene = Gltf("A ball for every feature of a material", (960, 600), {"spp": 512, "max-depth": 16})
    balls(scene)
    studio(scene)
    scene.perspective_camera(look_at((0.0, 0.86, 1.75), (0.0, 0.235, -0.25)), math.radians(26.0), 1.6)
    return {"gallery": scene}
