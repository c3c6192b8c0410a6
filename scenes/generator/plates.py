"""Veach's scene for multiple importance sampling (Veach and Guibas 1995, figure 2): four glossy metal plates
reflect four spheres of equal power and very different size. Small lights on rough plates need light sampling,
large lights on smooth plates need BSDF sampling."""
import math

from .gltf import Gltf
from .mesh import quad, sphere
from .vec import add, cross, look_at, normalize, scale, sub

CAMERA, TARGET = (0.0, 6.1, 15.0), (0.0, 2.1, 2.0)
LIGHT_ROW = (0.0, 4.2, 0.0)  # centre of the row of lights
LIGHT_X = (-3.75, -1.25, 1.25, 3.75)
LIGHT_RADIUS = (0.033, 0.1, 0.3, 0.9)
LIGHT_TINT = ((1.0, 0.62, 0.42), (1.0, 0.84, 0.50), (0.62, 1.0, 0.66), (0.50, 0.72, 1.0))
LUMINOUS_POWER = 36.0  # pi * area * luminance of each light

PLATE_CENTER = ((0.0, 1.72, -0.1), (0.0, 1.06, 0.95), (0.0, 0.54, 2.2), (0.0, 0.2, 3.6))  # back to front
PLATE_ROUGHNESS = (0.07, 0.14, 0.25, 0.5)  # perceptual: alpha 0.005 to 0.25
PLATE_SIZE = (8.0, 1.05)
PLATE_COLOR = (0.62, 0.62, 0.64)


def luminance(color):
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]


def plate(center):
    """A rectangle that mirrors the light row into the camera: its normal halves the angle between both."""
    normal = normalize(add(normalize(sub(CAMERA, center)), normalize(sub(LIGHT_ROW, center))))
    x = (PLATE_SIZE[0], 0.0, 0.0)
    up_the_plate = scale(normalize(cross(normal, x)), PLATE_SIZE[1])
    return quad(center, x, up_the_plate)


def build():
    scene = Gltf("Veach's plates: four roughnesses against four light sizes", (768, 512),
                 {"spp": 128, "max-depth": 8})
    grey = scene.diffuse("grey", (0.4, 0.4, 0.4))
    scene.add_surface("floor", quad((0.0, -0.1, 4.0), (0.0, 0.0, 16.0), (24.0, 0.0, 0.0)), grey)
    scene.add_surface("back wall", quad((0.0, 5.9, -4.0), (24.0, 0.0, 0.0), (0.0, 12.0, 0.0)), grey)

    for number, (center, roughness) in enumerate(zip(PLATE_CENTER, PLATE_ROUGHNESS), 1):
        scene.add_surface(f"plate {number}", plate(center),
                          scene.metal(f"metal of roughness {roughness}", PLATE_COLOR, roughness))

    ball = sphere(12)
    ball_area = ball.area()  # of the triangles, so that powers are equal exactly
    geometry = scene.geometry(ball)
    for x, radius, tint in zip(LIGHT_X, LIGHT_RADIUS, LIGHT_TINT):
        radiance = LUMINOUS_POWER / (math.pi * ball_area * radius**2 * luminance(tint))
        scene.add_mesh(f"light of radius {radius} m", geometry,
                       scene.light_material(f"emitter {radius}", scale(tint, radiance)),
                       add(LIGHT_ROW, (x, 0.0, 0.0)), radius)

    scene.perspective_camera(look_at(CAMERA, TARGET), math.radians(24.5), 1.5)
    return {"plates": scene}
