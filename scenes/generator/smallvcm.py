"""The Cornell scenes of SmallVCM (Davidovic and Georgiev, 2012), rebuilt: a box with a glossy floor that is open at the
front, with two small spheres (mirror, glass) or one large mirror sphere, under a sun, an area light, a point light or the
sky.
Measures are that program's, with y up; spheres are tessellated, and its Phong floor (diffuse 0.1, glossy 0.7, exponent 90)
is a metal of reflectance 0.7 and the microfacet roughness of equal width, alpha^2 = 2 / (90 + 2)."""
import math

from .gltf import Gltf
from .mesh import quad, sphere
from .vec import add, look_at

# Half width in x; floor and ceiling in y; back and front in z.
X, FLOOR, CEILING, BACK, FRONT = 1.27029, -1.28002, 1.28002, -1.30455, 1.25549
WHITE, GREEN, RED, BLUE = (0.8,) * 3, (0.156863, 0.803922, 0.172549), (0.803922, 0.152941, 0.152941), \
    (0.156863, 0.172549, 0.803922)
FLOOR_REFLECTANCE = 0.7
FLOOR_ROUGHNESS = (2.0 / 92.0) ** 0.25  # perceptual: the root of alpha
SMALL_RADIUS, LARGE_RADIUS, LIFT = 0.5, 0.8, 0.01
EYE, FORWARD = (-0.0439815, 0.222539, 4.12529), (0.00688625, -0.0542161, -0.998505)
FIELD_OF_VIEW = math.radians(45.0)
SUN_DIRECTION, SUN = (-1.0, -1.0, -1.5), (10.0, 4.0, 0.0)  # the way it shines; W/m^2
POINT_LIGHT, POINT_INTENSITY = (0.0, 1.0, 0.5), 70.0 / (4.0 * math.pi)
PANEL_HALF, PANEL_RADIANCE = 0.25, 25.03329895614464
SKY = (135 / 255, 206 / 255, 250 / 255)  # radiance from all directions


def box(scene):
    """Floor, ceiling, back and side walls, fronts inwards."""
    width, height, depth = (2 * X, 0.0, 0.0), (0.0, CEILING - FLOOR, 0.0), (0.0, 0.0, FRONT - BACK)
    mid_y, mid_z = (FLOOR + CEILING) / 2, (BACK + FRONT) / 2
    scene.add_surface("floor", quad((0.0, FLOOR, mid_z), depth, width),
                      scene.metal("glossy", (FLOOR_REFLECTANCE,) * 3, FLOOR_ROUGHNESS))
    scene.add_surface("ceiling", quad((0.0, CEILING, mid_z), width, depth), scene.diffuse("white", WHITE))
    scene.add_surface("back wall", quad((0.0, mid_y, BACK), width, height), scene.diffuse("blue", BLUE))
    scene.add_surface("left wall", quad((-X, mid_y, mid_z), height, depth), scene.diffuse("green", GREEN))
    scene.add_surface("right wall", quad((X, mid_y, mid_z), depth, height), scene.diffuse("red", RED))


def small_spheres(scene):
    ball = scene.geometry(sphere(32))
    for side, name, material in ((-1, "mirror sphere", scene.metal("mirror", (1.0, 1.0, 1.0), 0.0)),
                                 (1, "glass sphere", scene.glass("glass", 1.6))):
        center = (side * X * 3.0 / 7.0, FLOOR + SMALL_RADIUS + LIFT, (BACK + FRONT) / 2)
        scene.add_mesh(name, ball, material, center, SMALL_RADIUS)


def large_sphere(scene):
    scene.add_mesh("mirror sphere", scene.geometry(sphere(32)), scene.metal("mirror", (1.0, 1.0, 1.0), 0.0),
                   (0.0, FLOOR + LARGE_RADIUS + LIFT, (BACK + FRONT) / 2), LARGE_RADIUS)


def ceiling_panel(scene):
    panel = quad((0.0, CEILING - 0.02, 0.0), (2 * PANEL_HALF, 0.0, 0.0), (0.0, 0.0, 2 * PANEL_HALF))
    scene.add_surface("lamp", panel, scene.light_material("lamp", (PANEL_RADIANCE,) * 3))


def sun(scene):
    strength = max(SUN)
    scene.directional_light(SUN_DIRECTION, strength, [channel / strength for channel in SUN])


VARIANTS = {
    "sun": ("two small spheres, sun", small_spheres, sun),
    "ceiling": ("large mirror sphere, ceiling light", large_sphere, ceiling_panel),
    "point": ("two small spheres, point light", small_spheres,
              lambda scene: scene.point_light(POINT_LIGHT, POINT_INTENSITY)),
    "background": ("two small spheres, constant environment", small_spheres, lambda scene: scene.environment(SKY)),
}


def build():
    scenes = {}
    for name, (title, add_spheres, add_light) in VARIANTS.items():
        scene = Gltf(f"SmallVCM's Cornell box: glossy floor, {title}", (512, 512), {"spp": 256, "max-depth": 10})
        box(scene)
        add_spheres(scene)
        add_light(scene)
        scene.perspective_camera(look_at(EYE, add(EYE, FORWARD)), FIELD_OF_VIEW)
        scenes[f"smallvcm-{name}"] = scene
    return scenes
