"""What a rough metal reflects: the directional albedo of single-scattering Torrance-Sparrow with GGX and
Fresnel 1, for each shadowing term, by quadrature. The rest of the light is what the model is known to lose."""
import math


def _ggx_half_vectors(alpha, steps):
    """Midpoint grid over half vectors that are distributed as D(h) cos(h) (Walter et al. 2007, eq. 35)."""
    for i in range(steps):
        u = (i + 0.5) / steps
        tan_squared = alpha**2 * u / (1.0 - u)
        cos_theta = 1.0 / math.sqrt(1.0 + tan_squared)
        sin_theta = math.sqrt(max(0.0, 1.0 - cos_theta**2))
        for k in range(steps):
            phi = math.pi * (k + 0.5) / steps  # the half circle: the other half is its mirror image
            yield sin_theta * math.cos(phi), cos_theta


def _smith_lambda(alpha, cos_theta):
    return 0.5 * (math.sqrt(1.0 + alpha**2 * (1.0 / cos_theta**2 - 1.0)) - 1.0)


def _correlated(alpha, cos_o, cos_i, _cos_h, _cos_d):
    """Heitz 2014, eq. 99."""
    return 1.0 / (1.0 + _smith_lambda(alpha, cos_o) + _smith_lambda(alpha, cos_i))


def _uncorrelated(alpha, cos_o, cos_i, _cos_h, _cos_d):
    return 1.0 / ((1.0 + _smith_lambda(alpha, cos_o)) * (1.0 + _smith_lambda(alpha, cos_i)))


def _v_cavity(_alpha, cos_o, cos_i, cos_h, cos_d):
    """Torrance and Sparrow 1967."""
    return min(1.0, 2.0 * cos_h * cos_o / cos_d, 2.0 * cos_h * cos_i / cos_d)


SHADOWING = {"smith_correlated": _correlated, "smith_uncorrelated": _uncorrelated, "v_cavity": _v_cavity}


def albedos(alpha, cos_o, steps=96):
    """{shadowing: integral of f cos over the hemisphere} for light towards a direction at cos_o > 0."""
    sin_o = math.sqrt(1.0 - cos_o**2)
    sums = dict.fromkeys(SHADOWING, 0.0)
    for h_x, cos_h in _ggx_half_vectors(alpha, steps):
        cos_d = sin_o * h_x + cos_o * cos_h
        cos_i = 2.0 * cos_d * cos_h - cos_o
        if cos_d <= 0.0 or cos_i <= 0.0:
            continue
        for name, shadowing in SHADOWING.items():
            sums[name] += shadowing(alpha, cos_o, cos_i, cos_h, cos_d) * cos_d / (cos_o * cos_h)
    return {name: total / steps**2 for name, total in sums.items()}


def mean_over_facets(alpha, facets, nodes=32):
    """{shadowing: mean over (projected area, cosine) facets}, interpolated between cosine nodes."""
    table = [albedos(alpha, (k + 0.5) / nodes) for k in range(nodes)]
    total_area = sum(area for area, _ in facets)
    means = {}
    for name in SHADOWING:
        total = 0.0
        for area, cosine in facets:
            x = min(max(cosine * nodes - 0.5, 0.0), nodes - 1.001)
            low = int(x)
            total += area * (table[low][name] + (x - low) * (table[low + 1][name] - table[low][name]))
        means[name] = total / total_area
    return means
