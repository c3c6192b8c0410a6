#!/usr/bin/env python3
"""What a rough dielectric with a diffuse base returns of even light, by direction.

Independent of the renderer: E(w), the share that a GGX interface (alpha = roughness^2, height-correlated Smith) reflects at
once, is integrated over facet normals by the midpoint rule,

    E(o) = int F(o.h) G2(o, i, h) (o.h) / (cos_o cos_h)  D cos_h dh,      D cos_h dh = du dphi / (2 pi),
    tan^2 theta_h = alpha^2 u / (1 - u),

with the exact Fresnel reflectance F. Prints, for a base of the given albedo, three totals:

    rule    E(o) + base (1 - E(o))                                the diffuse lobe by (1 - E(o)) (1 - E(i)) / (1 - E_avg)
    smooth  E(o) + base (1 - F(o))                                by the smooth interface's Fresnel reflectance
    glTF    int ((1 - F(o.h)) base / pi + F(o.h) D V) cos_i di    specification, appendix B (F: Schlick from F0)

Usage: rough_base.py [albedo of the base, default .8] [index of refraction, default 1.5]
"""
import math
import sys

STEPS_U, STEPS_PHI = 256, 64
ANGLES = (0, 45, 60, 75, 85)
ROUGHNESS = (.1, .2, .3, .5, .7, 1)


def fresnel(c, n):
    g2 = n * n - 1 + c * c
    if g2 <= 0:
        return 1.0
    g = math.sqrt(g2)
    a = (g - c) / (g + c)
    b = (c * (g + c) - 1) / (c * (g - c) + 1)
    return .5 * a * a * (1 + b * b)


def smith_lambda(c, alpha):
    return .5 * (math.sqrt(1 + alpha * alpha * (1 - c * c) / (c * c)) - 1)


def facets(alpha):
    for k in range(STEPS_U):
        u = (k + .5) / STEPS_U
        u = u * u * (3 - 2 * u)  # finer at both ends
        weight = 6 * ((k + .5) / STEPS_U) * (1 - (k + .5) / STEPS_U) / STEPS_U
        t2 = alpha * alpha * u / (1 - u)
        cos_h = 1 / math.sqrt(1 + t2)
        sin_h = math.sqrt(t2) * cos_h
        for j in range(STEPS_PHI):
            phi = math.pi * (j + .5) / STEPS_PHI
            yield sin_h * math.cos(phi), cos_h, weight / STEPS_PHI


def albedos(cos_o, alpha, n, f0):
    """E with the exact Fresnel reflectance, and with Schlick's."""
    sin_o = math.sqrt(1 - cos_o * cos_o)
    lambda_o = smith_lambda(cos_o, alpha)
    exact = schlick = 0
    for x, z, weight in facets(alpha):
        c = sin_o * x + cos_o * z
        if c <= 0:
            continue
        cos_i = 2 * c * z - cos_o
        if cos_i <= 0:
            continue
        share = weight * c / (cos_o * z * (1 + lambda_o + smith_lambda(min(cos_i, 1), alpha)))
        exact += share * fresnel(c, n)
        schlick += share * (f0 + (1 - f0) * (1 - c) ** 5)
    return exact, schlick


def diffuse_of_specification(cos_o, f0):
    """int (1 - F(o.h)) cos_i di / pi over directions i."""
    steps_z, steps_phi = 200, 100
    sin_o = math.sqrt(1 - cos_o * cos_o)
    total = 0
    for k in range(steps_z):
        z = math.sqrt((k + .5) / steps_z)
        s = math.sqrt(1 - z * z)
        for j in range(steps_phi):
            dot = sin_o * s * math.cos(math.pi * (j + .5) / steps_phi) + cos_o * z
            total += 1 - f0 - (1 - f0) * (1 - math.sqrt(.5 * (1 + dot))) ** 5
    return total / (steps_z * steps_phi)


def main():
    base = float(sys.argv[1]) if len(sys.argv) > 1 else .8
    n = float(sys.argv[2]) if len(sys.argv) > 2 else 1.5
    f0 = ((n - 1) / (n + 1)) ** 2
    print(f"base {base}, index {n}\n")
    print("| roughness | angle | E | rule | smooth | glTF |\n|---|---|---|---|---|---|")
    for angle in ANGLES:
        cos_o = math.cos(math.radians(angle))
        diffuse = diffuse_of_specification(cos_o, f0)
        for roughness in ROUGHNESS:
            e, schlick = albedos(cos_o, roughness ** 2, n, f0)
            smooth = e + base * (1 - fresnel(cos_o, n))
            print(f"| {roughness} | {angle} | {e:.4f} | {e + base * (1 - e):.3f} | {smooth:.3f} "
                  f"| {schlick + base * diffuse:.3f} |")


main()
