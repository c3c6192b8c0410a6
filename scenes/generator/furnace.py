"""Closed scenes whose radiance is known. Balls are flat-shaded polyhedra: with shading normals that differ
from the surface no renderer conserves energy exactly, and the known values would not be exact."""
import math

from .directional_albedo import mean_over_facets
from .gltf import Gltf
from .mesh import box, facing_facets, sphere
from .vec import add, length, look_at, scale

EMISSION = (0.5, 1.0, 2.0)
ALBEDO = (0.2, 0.5, 0.8)
ROUGHNESS = 0.7  # perceptual: alpha 0.49
BALL_RADIUS = 0.5
FILM_HALF_WIDTH = 0.6  # furnace-rough
POINT_INTENSITY = 2.0
POINT_SPHERE_RADIUS = 2.0
EYE = (1.6, 1.5, 1.7)  # sees three faces of a cube at no more than 72 degrees


def room():
    """A box of 4 m whose front faces face inwards."""
    return box((-2.0, -2.0, -2.0), (2.0, 2.0, 2.0)).turned_inside_out()


def look_at_center(scene, eye, y_fov_degrees):
    scene.perspective_camera(look_at(eye, (0.0, 0.0, 0.0)), math.radians(y_fov_degrees))


def lambert():
    """Every wall emits EMISSION and reflects ALBEDO: the path edge k + 1 adds EMISSION * ALBEDO^k."""
    depth = 12
    series = [e * (1 - a**depth) / (1 - a) for e, a in zip(EMISSION, ALBEDO)]
    limit = [e / (1 - a) for e, a in zip(EMISSION, ALBEDO)]
    scene = Gltf("Lambert furnace", (64, 64), {"spp": 64, "max-depth": depth},
                 {"max_depth": depth, "radiance": series, "radiance_unlimited_depth": limit})
    scene.add_surface("room", room(), scene.diffuse("glowing white", ALBEDO, EMISSION))
    look_at_center(scene, EYE, 90)
    return scene


def with_solid(title, mesh, add_material, depth):
    """A solid that absorbs nothing in a black room that emits EMISSION: the solid cannot be seen."""
    scene = Gltf(title, (64, 64), {"spp": 64, "max-depth": depth},
                 {"max_depth": depth, "radiance": list(EMISSION)})
    scene.add_surface("room", room(), scene.light_material("glow", EMISSION))
    scene.add_mesh("solid", scene.geometry(mesh), add_material(scene), scale=BALL_RADIUS)
    look_at_center(scene, EYE, 36)
    return scene


def glass():
    """A glass cube, not a ball: in a polyhedral ball some light circles for hundreds of reflections and a
    finite depth would lose it. Light that enters a cube through a face meets that face and its opposite below
    the critical angle for ever, so that all but the Fresnel reflectance F leaves at each crossing. Seen from
    EYE F is at most 0.2, and a path of 32 edges crosses 10 times or more: less than 1e-6 is lost."""
    cube = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    return with_solid("Furnace with a glass cube", cube, lambda scene: scene.glass("glass", 1.5), 32)


def mirror():
    return with_solid("Furnace with a mirror ball", sphere(16).flat(),
                      lambda scene: scene.metal("mirror", (1, 1, 1), 0.0), 4)


def rough():
    """A rough metal ball of Fresnel 1: darker than the room by the light that single scattering loses."""
    ball = sphere(16).flat()
    facets = facing_facets(ball, (0.0, 0.0, 1.0))
    covered = BALL_RADIUS**2 * sum(area for area, _ in facets) / (2 * FILM_HALF_WIDTH)**2
    albedos = mean_over_facets(ROUGHNESS**2, facets)
    expected = {
        "ball_mean_albedo": {name: round(value, 6) for name, value in albedos.items()},
        "image_mean": {name: [round(e * (1 - covered * (1 - value)), 6) for e in EMISSION]
                       for name, value in albedos.items()},
        "relative_error_of_quadrature": 5e-4,
    }
    scene = Gltf("Furnace with a rough metal ball", (64, 64), {"spp": 256, "max-depth": 4}, expected)
    scene.add_surface("room", room(), scene.light_material("glow", EMISSION))
    scene.add_mesh("ball", scene.geometry(ball), scene.metal("rough metal", (1, 1, 1), ROUGHNESS),
                   scale=BALL_RADIUS)
    scene.orthographic_camera(look_at((0.0, 0.0, 1.5), (0.0, 0.0, 0.0)), FILM_HALF_WIDTH, FILM_HALF_WIDTH)
    return scene


def point():
    """A point light in the centre of a Lambert sphere. All its power 4 pi I meets the sphere's area A, so the
    mean radiance over A after one reflection is a 4 I / A, and each further edge multiplies by a."""
    depth = 12
    mesh = sphere(32).flat().turned_inside_out()
    area = mesh.area() * POINT_SPHERE_RADIUS**2
    once = [a * 4.0 * POINT_INTENSITY / area for a in ALBEDO]
    # Irradiance over a facet goes as 1 / distance^3 times the facet's constant distance from the centre.
    nearest = min(length(add(add(a, b), c)) / 3 for a, b, c in mesh.corners())
    expected = {
        "max_depth": depth,
        "radiance": [value * (1 - a**(depth - 1)) / (1 - a) for value, a in zip(once, ALBEDO)],
        "radiance_unlimited_depth": [value / (1 - a) for value, a in zip(once, ALBEDO)],
        "relative_spread_over_facets": round(1 / nearest**2 - 1, 6),
    }
    scene = Gltf("Point light in a Lambert sphere", (64, 64), {"spp": 64, "max-depth": depth}, expected)
    scene.add_mesh("sphere", scene.geometry(mesh), scene.diffuse("white", ALBEDO), scale=POINT_SPHERE_RADIUS)
    scene.point_light((0.0, 0.0, 0.0), POINT_INTENSITY)
    look_at_center(scene, scale(EYE, 0.4), 90)
    return scene


def build():
    return {"furnace": lambert(), "furnace-glass": glass(), "furnace-mirror": mirror(),
            "furnace-rough": rough(), "furnace-point": point()}
