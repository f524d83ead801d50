"""Points on patches and directions above them, from sequences that fill their domain evenly.

The functions compute one ray or segment when compiled; as they are they serve arrays too, with the same bits. A patch
is an array of 4 x 3 coordinates, or of 4 x 3 x K.
"""

import numpy as np

from golden.base.compiled import compiled
from golden.light.sampling import scrambled

__all__ = ["REPLICATES", "cosine_direction", "depart", "join_by_direction", "join_by_points", "point_on", "ray",
           "segment_by_direction", "segment_by_points", "sequence", "weighted_point_on"]

# Independent shifts of one sequence: the variance of their results estimates that of the mean.
REPLICATES = 16


def _sobol_table():
    """Of Sobol's sequence 4 x 4 x 256 uint64: per dimension what each byte of a number adds (exclusive or), 53 bits."""
    numbers = np.arange(256)
    table = np.zeros((4, 4, 256), dtype=np.uint64)
    # Degree, inner coefficients and first numbers of Joe and Kuo's primitive polynomials.
    for dimension, (degree, inner, first) in enumerate(((0, 0, ()), (1, 0, (1,)), (2, 1, (1, 3)), (3, 1, (1, 3, 1)))):
        odd = list(first) if degree else [1] * 32
        for bit in range(len(odd), 32):
            value = odd[bit - degree] ^ odd[bit - degree] << degree
            for digit in range(1, degree):
                value ^= (inner >> degree - 1 - digit & 1) * odd[bit - digit] << digit
            odd.append(value)
        for bit in range(32):
            table[dimension, bit // 8] ^= np.uint64(odd[bit] << 52 - bit) * (numbers >> bit % 8 & 1).astype(np.uint64)
    return table


_SOBOL = _sobol_table()

# Of the splitmix64 generator, as in `golden.light.sampling`, and what it adds for the four numbers of a use.
_scramble = compiled(scrambled)
_WEYL, _11, _ONE = np.uint64(0x9E3779B97F4A7C15), np.uint64(11), np.uint64(1)
_DIMENSION_0, _DIMENSION_1, _DIMENSION_2, _DIMENSION_3 = np.arange(1, 5, dtype=np.uint64) * _WEYL


@compiled
def sequence(use, number):
    """Four numbers in [0, 1): number k belongs to replicate k modulo `REPLICATES`.

    Parameters
    ----------
    use
        Uint64, a hash of what the numbers are for (`golden.light.sampling.mix`).
    number
        Int64 within the use; the points of numbers 0 to n - 1 fill the cube evenly for each n. The last two coordinates
        fill their square most evenly.

    Source: Joe, Kuo, Constructing Sobol sequences with better two-dimensional projections (2008), with the random
    digital shift of L'Ecuyer, Lemieux, Recent advances in randomized quasi-Monte Carlo methods (2002).
    """
    turn = number // REPLICATES
    state = _scramble(use + _WEYL * (np.uint64(number - turn * REPLICATES) + _ONE))
    return (_shifted(state, _DIMENSION_0, 2, turn), _shifted(state, _DIMENSION_1, 3, turn),
            _shifted(state, _DIMENSION_2, 0, turn), _shifted(state, _DIMENSION_3, 1, turn))


@compiled
def point_on(patch, triangle, u, v):
    """X, y and z of a point that is uniform by area on a patch, for uniform u and v."""
    # Of the triangles (0, 1, 2) and (0, 2, 3) the first one has the lower part of u.
    first = _twice_area(patch, 1, 2)
    share = _chosen(triangle, 1.0, first / (first + _twice_area(patch, 2, 3)))
    lower = u < share
    along = _chosen(lower, u / np.maximum(share, 1e-300), (u - share) / _chosen(lower, 1.0, 1 - share))
    side = np.sqrt(v)
    return (_between(patch, 0, lower, along, side), _between(patch, 1, lower, along, side),
            _between(patch, 2, lower, along, side))


@compiled
def weighted_point_on(patch, triangle, u, v):
    """X, y and z of a point by a smooth map of the unit square to a patch, and its area vector."""
    # A triangle's two last vertices are one, to which v = 1 leads: the root makes its points uniform.
    root = _chosen(triangle, np.sqrt(1 - v), 0.5)
    v = _chosen(triangle, 1 - root, v)
    x, ux, vx = _mapped(patch, 0, u, v)
    y, uy, vy = _mapped(patch, 1, u, v)
    z, uz, vz = _mapped(patch, 2, u, v)
    scale = 0.5 / root
    return x, y, z, (uy * vz - uz * vy) * scale, (uz * vx - ux * vz) * scale, (ux * vy - uy * vx) * scale


@compiled
def cosine_direction(axes, u, v):
    """A unit vector distributed by the cosine with the third of 3 x 3 axes, for uniform u and v."""
    cosine, sine = _turn(u)
    radius, height = np.sqrt(v), np.sqrt(1 - v)
    a, b = radius * cosine, radius * sine
    return (a * axes[0, 0] + b * axes[1, 0] + height * axes[2, 0],
            a * axes[0, 1] + b * axes[1, 1] + height * axes[2, 1],
            a * axes[0, 2] + b * axes[1, 2] + height * axes[2, 2])


@compiled
def ray(use, number, patch, triangle, axes):
    """Origin and direction of a ray of a patch's hemisphere."""
    a, b, c, d = sequence(use, number)
    x, y, z = point_on(patch, triangle, a, b)
    dx, dy, dz = cosine_direction(axes, c, d)
    return x, y, z, dx, dy, dz


@compiled
def segment_by_direction(use, number, patch, triangle, axes, other, normal):
    """Ends of a segment along a ray of the first patch's hemisphere, and 1 if it meets the second one's front, else 0.

    The normal is the second patch's.
    """
    x, y, z, dx, dy, dz = ray(use, number, patch, triangle, axes)
    falls = -(dx * normal[0] + dy * normal[1] + dz * normal[2])
    height = ((x - other[0, 0]) * normal[0] + (y - other[0, 1]) * normal[1] + (z - other[0, 2]) * normal[2])
    ahead = (falls > 0) & (height > 0)
    distance = height / _chosen(ahead, falls, 1.0)
    px, py, pz = x + distance * dx, y + distance * dy, z + distance * dz
    inside = (ahead & _left(other, 0, 1, normal, px, py, pz) & _left(other, 1, 2, normal, px, py, pz)
              & _left(other, 2, 3, normal, px, py, pz) & _left(other, 3, 0, normal, px, py, pz))
    return x, y, z, px, py, pz, inside * 1.0


@compiled
def segment_by_points(use, number, patch, triangle, other, other_triangle):
    """Ends of a segment between points on two patches, and its weight cos cos dA dA' / r^2."""
    a, b, c, d = sequence(use, number)
    x, y, z, ax, ay, az = weighted_point_on(patch, triangle, a, b)
    px, py, pz, bx, by, bz = weighted_point_on(other, other_triangle, c, d)
    dx, dy, dz = px - x, py - y, pz - z
    square = dx * dx + dy * dy + dz * dz
    weight = np.maximum(dx * ax + dy * ay + dz * az, 0.0) * np.maximum(-(dx * bx + dy * by + dz * bz), 0.0)
    # A sum with 0 is never the negative zero.
    return x, y, z, px, py, pz, weight * (square > 0) / _chosen(square > 0, square * square, 1.0) + 0.0


@compiled
def depart(use, number, side, vertices, triangle, axes, origin, direction):
    """Write the `ray` of each of K sides."""
    for k in range(len(side)):
        (origin[k, 0], origin[k, 1], origin[k, 2], direction[k, 0], direction[k, 1], direction[k, 2]) = ray(
            use[k], number[k], vertices[side[k]], triangle[side[k]], axes[side[k]])


@compiled
def join_by_direction(use, number, first, second, vertices, triangle, axes, origin, target, weight):
    """Write the `segment_by_direction` of each of K pairs."""
    for k in range(len(first)):
        a, b = first[k], second[k]
        (origin[k, 0], origin[k, 1], origin[k, 2], target[k, 0], target[k, 1], target[k, 2], weight[k]) = \
            segment_by_direction(use[k], number[k], vertices[a], triangle[a], axes[a], vertices[b], axes[b, 2])


@compiled
def join_by_points(use, number, first, second, vertices, triangle, origin, target, weight):
    """Write the `segment_by_points` of each of K pairs."""
    for k in range(len(first)):
        a, b = first[k], second[k]
        (origin[k, 0], origin[k, 1], origin[k, 2], target[k, 0], target[k, 1], target[k, 2], weight[k]) = \
            segment_by_points(use[k], number[k], vertices[a], triangle[a], vertices[b], triangle[b])


@compiled
def _shifted(state, dimension, axis, turn):
    """A coordinate of a point of Sobol's sequence, shifted by a hash."""
    return ((_scramble(state + dimension) >> _11)
            ^ _SOBOL[axis, 0, turn & 255] ^ _SOBOL[axis, 1, turn >> 8 & 255]
            ^ _SOBOL[axis, 2, turn >> 16 & 255] ^ _SOBOL[axis, 3, turn >> 24 & 255]) * 2.0**-53


@compiled
def _turn(u):
    """Cosine and sine of u whole turns by their series, whose bits depend on no library."""
    quarter = np.floor(4 * u + 0.5)
    x = (4 * u - quarter) * (np.pi / 2)
    y = x * x
    even = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90 * (1 - y / 132 * (
        1 - y / 182 * (1 - y / 240)))))))
    odd = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110 * (1 - y / 156 * (
        1 - y / 210)))))))
    across = (quarter == 1) | (quarter == 3)
    cosine, sine = _chosen(across, odd, even), _chosen(across, even, odd)
    return (_chosen((quarter == 1) | (quarter == 2), -cosine, cosine),
            _chosen((quarter == 2) | (quarter == 3), -sine, sine))


@compiled
def _chosen(condition, one, other):
    """One of two finite numbers; numpy's own choice costs a compiled loop far more."""
    return one * condition + other * (1 - condition)


@compiled
def _twice_area(patch, second, third):
    """Twice the area of the triangle of corner 0 and two others."""
    ax, ay, az = patch[second, 0] - patch[0, 0], patch[second, 1] - patch[0, 1], patch[second, 2] - patch[0, 2]
    bx, by, bz = patch[third, 0] - patch[0, 0], patch[third, 1] - patch[0, 1], patch[third, 2] - patch[0, 2]
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return np.sqrt(x * x + y * y + z * z)


@compiled
def _between(patch, axis, lower, along, side):
    """A coordinate of the point a share along the far edge of one of a patch's triangles, and so far towards it."""
    start = _chosen(lower, patch[1, axis], patch[2, axis])
    end = _chosen(lower, patch[2, axis], patch[3, axis])
    return patch[0, axis] + side * (start - patch[0, axis] + along * (end - start))


@compiled
def _mapped(patch, axis, u, v):
    """A coordinate of the bilinear map and its derivatives along u and v."""
    bottom, top = patch[1, axis] - patch[0, axis], patch[2, axis] - patch[3, axis]
    low, high = patch[0, axis] + u * bottom, patch[3, axis] + u * top
    return low + v * (high - low), (1 - v) * bottom + v * top, high - low


@compiled
def _left(patch, corner, after, normal, x, y, z):
    """Whether a point in a patch's plane is on the inner side of an edge."""
    ax, ay, az = patch[corner, 0] - x, patch[corner, 1] - y, patch[corner, 2] - z
    bx, by, bz = patch[after, 0] - x, patch[after, 1] - y, patch[after, 2] - z
    return ((ay * bz - az * by) * normal[0] + (az * bx - ax * bz) * normal[1] + (ax * by - ay * bx) * normal[2]) >= 0
