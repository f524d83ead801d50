"""Integrals of ln r over pairs of line segments: the terms of a form factor's double contour integral."""

import numpy as np

__all__ = ["edge_integrals"]

# Sines of the angle between two lines: up to the first they count as parallel, since then the difference is below
# rounding; up to the second the closed form of crossing lines, whose crossing is far away, would lose digits.
_PARALLEL, _NEARLY_PARALLEL = 1e-11, 1e-2

# Gauss points of each piece where no closed form exists, and where a piece's ends are singular as well.
_SKEW, _GRADED = 16, 32


def edge_integrals(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Integrals of ln r over both lengths, r the distance of a point of one segment from a point of the other.

    Segments may touch, cross and overlap: the integrand's singularity is integrated in closed form. With the lines'
    crossing (or their points nearest to each other) as origins of s and t, r^2 = s^2 + t^2 - 2 s t cos(theta) + h^2.
    Then s dr/ds + t dr/dt = (r^2 - h^2) / r, so by Gauss' theorem 2 ln r integrates to terms of the borders, less the
    area, plus h^2 times the integral of 1 / r^2. The last vanishes for coplanar lines; for skew ones half of it is in
    closed form and the rest is smooth.

    Parameters
    ----------
    first, second
        E x 2 x 3 ends of the segments, none of length zero.

    Returns
    -------
    E float64.

    Source: Schroeder and Hanrahan, On the form factor between two polygons (1993), for the problem.
    """
    along_1, along_2 = first[:, 1] - first[:, 0], second[:, 1] - second[:, 0]
    length_1, length_2 = np.linalg.norm(along_1, axis=1), np.linalg.norm(along_2, axis=1)
    unit_1, unit_2 = along_1 / length_1[:, None], along_2 / length_2[:, None]
    sine = np.linalg.norm(np.cross(unit_1, unit_2), axis=1)
    total = np.empty(len(first))
    for integral, rows in ((_parallel, sine <= _PARALLEL), (_crossing, sine > _NEARLY_PARALLEL),
                           (_nearly_parallel, (sine > _PARALLEL) & (sine <= _NEARLY_PARALLEL))):
        rows = np.flatnonzero(rows)
        if len(rows):
            total[rows] = integral(second[rows, 0] - first[rows, 0], unit_1[rows], unit_2[rows], length_1[rows],
                                   length_2[rows])
    return total


def _parallel(between, unit_1, unit_2, length_1, length_2):
    """Of parallel segments, in closed form; ``between`` leads from the first one's start to the second one's."""
    start = np.einsum("ij,ij->i", between, unit_1)
    height = np.linalg.norm(between - start[:, None] * unit_1, axis=1)
    end = start + length_2 * np.sign(np.einsum("ij,ij->i", unit_1, unit_2))
    low, high = np.minimum(start, end), np.maximum(start, end)
    return (_twice_integrated(length_1 - low, height) - _twice_integrated(length_1 - high, height)
            + _twice_integrated(-high, height) - _twice_integrated(-low, height))


def _crossing(between, unit_1, unit_2, length_1, length_2):
    """Of segments whose lines have an angle, coplanar or skew; the parameters are those of `_parallel`."""
    cosine = np.einsum("ij,ij->i", unit_1, unit_2)
    across = np.cross(unit_1, unit_2)
    square = np.einsum("ij,ij->i", across, across)
    sine = np.sqrt(square)
    height = np.abs(np.einsum("ij,ij->i", between, across)) / sine
    s_low = -np.einsum("ij,ij->i", np.cross(between, unit_2), across) / square
    t_low = -np.einsum("ij,ij->i", np.cross(between, unit_1), across) / square
    s_high, t_high = s_low + length_1, t_low + length_2
    total = -length_1 * length_2
    for s, sign in ((s_high, 1), (s_low, -1)):
        total += sign * s * _along(t_low - s * cosine, t_high - s * cosine, np.hypot(s * sine, height))
    for t, sign in ((t_high, 1), (t_low, -1)):
        total += sign * t * _along(s_low - t * cosine, s_high - t * cosine, np.hypot(t * sine, height))
    skew = np.flatnonzero(height > 1e-12 * (length_1 + length_2))
    if len(skew):
        arguments = (value[skew] for value in (s_low, s_high, t_low, t_high, cosine, sine, height))
        total[skew] += height[skew]**2 * _inverse_square(*arguments)
    return total / 2


def _inverse_square(s_low, s_high, t_low, t_high, cosine, sine, height):
    """The integral of 1 / r^2 over s and t: over s in closed form, over t by Gauss points in asinh(t sine / height)."""
    share = sine / height
    # Between these the arc tangents are smooth.
    with np.errstate(divide="ignore", invalid="ignore"):
        cuts = [np.clip(np.nan_to_num(s / cosine), t_low, t_high) for s in (s_low, s_high)]
    cuts = np.sort(np.stack([t_low, *cuts, np.clip(0, t_low, t_high), t_high], axis=1), axis=1)
    ends = np.arcsinh(cuts * share[:, None])
    knots, gauss = np.polynomial.legendre.leggauss(_SKEW)
    middle, half = (ends[:, 1:] + ends[:, :-1]) / 2, (ends[:, 1:] - ends[:, :-1]) / 2
    x = middle[:, :, None] + half[:, :, None] * knots
    t = np.sinh(x) / share[:, None, None]
    distance = height[:, None, None] * np.cosh(x)
    s_low, s_high, cosine = (value[:, None, None] for value in (s_low, s_high, cosine))
    angle = np.arctan2(s_high - t * cosine, distance) - np.arctan2(s_low - t * cosine, distance)
    return np.einsum("epq,q,ep->e", angle, gauss, half) / sine


def _nearly_parallel(between, unit_1, unit_2, length_1, length_2):
    """Over the second segment in closed form, over the first by Gauss points that crowd at the singular points."""
    ends = between[:, None] + np.stack([0 * length_2, length_2], axis=1)[:, :, None] * unit_2[:, None]
    across = np.cross(unit_1, unit_2)
    crossing = np.einsum("ij,ij->i", np.cross(between, unit_2), across) / np.einsum("ij,ij->i", across, across)
    cuts = np.concatenate([np.einsum("eki,ei->ek", ends, unit_1), crossing[:, None]], axis=1)
    cuts = np.clip(cuts, 0, length_1[:, None])
    cuts = np.sort(np.concatenate([cuts, np.stack([0 * length_1, length_1], axis=1)], axis=1), axis=1)
    knots, gauss = np.polynomial.legendre.leggauss(_GRADED)
    u = (knots + 1) / 2
    graded, density = u**3 * (10 - 15 * u + 6 * u * u), 15 * (u * (1 - u))**2 * gauss
    width = np.diff(cuts, axis=1)
    s = cuts[:, :-1, None] + width[:, :, None] * graded
    offset = s[..., None] * unit_1[:, None, None] - between[:, None, None]
    foot = np.einsum("epqi,ei->epq", offset, unit_2)
    distance = np.linalg.norm(offset - foot[..., None] * unit_2[:, None, None], axis=-1)
    inner = _along(-foot, length_2[:, None, None] - foot, distance)
    return np.einsum("epq,q,ep->e", inner, density, width)


def _along(low, high, distance):
    """The integral of ln r over a line between two points, from a point at a distance from the line."""
    return _integrated(high, distance) - _integrated(low, distance)


def _integrated(x, h):
    """The integral of ln(x^2 + h^2) / 2 over x."""
    return x * (_log(x, h) - 1) + h * np.arctan2(x, h)


def _twice_integrated(x, h):
    """The second integral of ln(x^2 + h^2) / 2 over x."""
    return (x - h) * (x + h) / 2 * _log(x, h) - 0.75 * x * x + h * x * np.arctan2(x, h)


def _log(x, h):
    """The logarithm of hypot(x, h), or 0 at 0, where its factor vanishes."""
    r = np.hypot(x, h)
    return np.log(np.where(r > 0, r, 1.0))
