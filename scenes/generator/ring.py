"""Two metal rings on a table under a small lamp: light that a ring reflects gathers in a cusped caustic inside and beside
it. Measures of real rings, a lamp of 6 mm at 20 cm, large dim panels so that metal has something to show."""
import math

from .gltf import Gltf
from .mesh import Mesh, join, quad, sphere
from .solids import arc, lathe, line, moved, tilted_frame
from .vec import look_at

GOLD, SILVER = (0.94, 0.73, 0.36), (0.93, 0.92, 0.90)
TABLE = (0.55, 0.52, 0.48)
LAMP, LAMP_RADIUS, LAMP_RADIANCE = (-0.13, 0.135, -0.07), 0.003, (6800.0, 6100.0, 5000.0)
# Centre and edges of each: above, behind, on the right; fronts towards the rings.
PANELS = (((0.0, 0.5, 0.1), (0.5, 0.0, 0.0), (0.0, 0.0, 0.3)), ((0.0, 0.18, -0.55), (0.9, 0.0, 0.0), (0.0, 0.3, 0.0)),
          ((0.5, 0.2, 0.1), (0.0, 0.0, 0.5), (0.0, 0.34, 0.0)))
PANEL_RADIANCE = (0.42, 0.50, 0.62)
LEAN = math.radians(62.0)  # of the thin ring's axis


def band(radius, thickness, height):
    """A ring about y on y = 0: cylindrical outside and slightly domed inside, rounded edges."""
    edge = 0.35 * thickness
    outer, inner = radius + thickness, radius
    return lathe([
        line((inner + edge, 0.0), (outer - edge, 0.0)), arc((outer - edge, edge), edge, -90, 0, 10),
        line((outer, edge), (outer, height - edge)), arc((outer - edge, height - edge), edge, 0, 90, 10),
        line((outer - edge, height), (inner + edge, height)), arc((inner + edge, height - edge), edge, 90, 180, 10),
        line((inner, height - edge), (inner, edge)), arc((inner + edge, edge), edge, 180, 270, 10)], 192)


def wire(radius, thickness):
    """A torus about y."""
    return lathe([arc((radius, 0.0), thickness, 0, 360, 40)], 192)


def build():
    scene = Gltf("Caustics of two metal rings", (768, 512), {"spp": 512, "max-depth": 10, "merge-radius": "0.0005",
                                              "exposure": -0.5})
    scene.add_surface("table", quad((0.0, 0.0, 0.0), (0.0, 0.0, 1.2), (1.2, 0.0, 0.0)), scene.diffuse("table", TABLE))
    scene.add_surface("gold ring", band(0.0090, 0.0016, 0.0055), scene.metal("gold", GOLD, 0.0))

    # Leans on the gold ring's upper outer edge.
    radius, thickness = 0.0088, 0.0008
    axes = tilted_frame((math.sin(LEAN), math.cos(LEAN), 0.0), (0.0, 0.0, 1.0))
    height = radius * math.sin(LEAN) + thickness
    scene.add_surface("silver ring", moved(wire(radius, thickness), *axes, (0.0089, height, 0.0035)),
                      scene.metal("silver", SILVER, 0.0))

    scene.add_mesh("lamp", scene.geometry(sphere(12)), scene.light_material("lamp", LAMP_RADIANCE), LAMP, LAMP_RADIUS)
    panels = Mesh([], [], [])
    for center, u, v in PANELS:
        join(panels, quad(center, u, v))
    scene.add_surface("panels", panels, scene.light_material("panel", PANEL_RADIANCE))
    scene.perspective_camera(look_at((0.022, 0.058, 0.078), (0.0065, 0.0005, 0.0015)), math.radians(30.0), 1.5)
    return {"ring": scene}
