"""A point light between two parallel perfect mirrors and a small receiver: every light path over mirrors has
a closed form by image sources. Coordinates are those of the note on regularization: light (0, 0, 1.1),
mirrors z = 0 and z = 2, receiver (4, 0.3, 0.9) with normal -x.

A path tracer without regularization finds the direct light alone: no sampled direction meets a point light,
and no connection passes a perfect mirror. What a regularized or a light tracer must add is listed per chain."""
import math

from .gltf import Gltf
from .mesh import quad
from .vec import look_at

LIGHT = (0.0, 0.0, 1.1)
MIRROR_Z = (0.0, 2.0)
RECEIVER = (4.0, 0.3, 0.9)  # normal -x
INTENSITY = 30.0            # W/sr
ALBEDO = 0.5
MAX_DEPTH = 12              # path edges: camera, light, and one more per mirror
FILM_HALF_WIDTH = 0.01      # m: the camera sees a square of 2 cm on the receiver
MIRROR_HALF_SIZE = 20.0


def unfold(chain, z):
    """Height of the image source of a light at height z after the mirrors of the chain, light first."""
    for mirror in chain:
        z = 2.0 * MIRROR_Z[mirror] - z
    return z


def chains(bounces):
    """Both orders in which light can alternate between the mirrors; one empty chain for none."""
    return [[]] if bounces == 0 else [[(first + i) % 2 for i in range(bounces)] for first in (0, 1)]


def irradiance(chain, point):
    """I cos(theta) / d^2 of the image source at a point of the receiver's plane."""
    d = (point[0] - LIGHT[0], point[1] - LIGHT[1], point[2] - unfold(chain, LIGHT[2]))
    squared = d[0]**2 + d[1]**2 + d[2]**2
    return INTENSITY * d[0] / squared**1.5


def check_chain(chain):
    """The real path of a chain exists: unfolded it is a straight line, which meets the mirrors' images in
    order, within the mirrors' extents."""
    source, target = unfold(chain, LIGHT[2]), RECEIVER[2]
    passed = 0.0
    for done in range(1, len(chain) + 1):
        # The image of mirror `done` as the light, unfolded, sees it: reflect it by the chain's other mirrors.
        plane = MIRROR_Z[chain[done - 1]]
        for mirror in chain[done:]:
            plane = 2.0 * MIRROR_Z[mirror] - plane
        t = (plane - source) / (target - source)
        assert passed < t < 1.0, chain
        passed = t
        for axis in (0, 1):
            at = LIGHT[axis] + t * (RECEIVER[axis] - LIGHT[axis])
            assert abs(at) < 0.5 * MIRROR_HALF_SIZE, chain


def film_mean(chain, steps=8):
    """Irradiance averaged over the square that the camera sees (midpoint rule: relative error about
    (step / distance)^2, below 1e-6)."""
    total = 0.0
    for i in range(steps):
        for j in range(steps):
            dy, dz = (((k + 0.5) / steps * 2.0 - 1.0) * FILM_HALF_WIDTH for k in (i, j))
            total += irradiance(chain, (RECEIVER[0], RECEIVER[1] + dy, RECEIVER[2] + dz))
    return total / steps**2


def expected():
    """Known values: irradiance at the receiver's centre per chain, and the mean of the image."""
    rows = []
    radiance = []
    for bounces in range(MAX_DEPTH - 1):
        of_length = chains(bounces)
        for chain in of_length:
            check_chain(chain)
            rows.append({"mirrors_from_light": [f"z={MIRROR_Z[m]:g}" for m in chain], "edges": bounces + 2,
                         "irradiance": irradiance(chain, RECEIVER)})
        radiance.append(sum(film_mean(chain) for chain in of_length) * ALBEDO / math.pi)
    return {
        "irradiance_per_chain": rows,
        "radiance_by_mirror_bounces": radiance,
        "radiance_direct": radiance[0],
        "radiance_all": sum(radiance),
        "max_depth": MAX_DEPTH,
    }


def build():
    scene = Gltf("A point light between two mirrors", (16, 16), {"spp": 64, "max-depth": MAX_DEPTH}, expected())
    mirror = scene.metal("mirror", (1, 1, 1), 0.0)
    size = 2.0 * MIRROR_HALF_SIZE
    scene.add_surface("mirror z=0", quad((0.0, 0.0, MIRROR_Z[0]), (size, 0.0, 0.0), (0.0, size, 0.0)), mirror)
    scene.add_surface("mirror z=2", quad((0.0, 0.0, MIRROR_Z[1]), (0.0, size, 0.0), (size, 0.0, 0.0)), mirror)
    scene.add_surface("receiver", quad(RECEIVER, (0.0, 0.0, 0.1), (0.0, 0.1, 0.0)),
                      scene.diffuse("receiver", (ALBEDO,) * 3))
    scene.point_light(LIGHT, INTENSITY)
    eye = (RECEIVER[0] - 0.5, RECEIVER[1], RECEIVER[2])
    scene.orthographic_camera(look_at(eye, RECEIVER, up=(0.0, 0.0, 1.0)), FILM_HALF_WIDTH, FILM_HALF_WIDTH)
    return {"mirrors": scene}
