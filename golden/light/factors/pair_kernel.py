"""The arithmetic of pairs of patches, pair by pair."""

import numpy as np

from golden.base.compiled import compiled

__all__ = ["candidates", "exchange_of_far"]

# A corner whose distance from the other patch's plane is below this share of the pair's size counts as in the plane.
_IN_PLANE = 1e-12


@compiled
def candidates(rows, centre, normal, radius, area, limit, all_pairs):
    """The rows and columns, in order, of the pairs that a row measures and whose balls allow a factor above the limit.

    The smaller patch measures, of equal ones either by parity; if ``all_pairs`` any row does.

    Parameters
    ----------
    rows
        Numbers of sides.
    centre, normal, radius, area
        Of all N sides: their balls, their planes' normals, and their areas.
    """
    row_of, column_of = np.empty((2, len(rows) * len(area)), dtype=np.int64)
    found = 0
    for row in rows:
        for column in range(len(area)):
            over_row = over_column = square = 0.0
            for axis in range(3):
                way = centre[column, axis] - centre[row, axis]
                square += way * way
                over_row += way * normal[row, axis]
                over_column += way * normal[column, axis]
            gap = np.sqrt(square) - radius[column] - radius[row]
            # Heights of the balls over each other's planes.
            over_row, over_column = over_row + radius[column], radius[row] - over_column
            if over_row <= 0 or over_column <= 0:
                continue
            large = area[column] * min(over_row, gap) * min(over_column, gap) > limit * np.pi * (gap * gap) * (
                gap * gap)
            excess = area[column] / area[row] - 1
            owns = excess > 1e-9 or (abs(excess) <= 1e-9 and ((row + column) % 2 == 0) == (row < column))
            if (owns or all_pairs) and (large or gap <= 0):
                row_of[found], column_of[found] = row, column
                found += 1
    return row_of[:found].copy(), column_of[:found].copy()


@compiled
def exchange_of_far(first, second, limits, begin, rules, total, kind, over):
    """Exchange areas of far pairs by Gauss points on both patches.

    Parameters
    ----------
    first, second
        P x 4 x 3 vertices.
    limits, begin, rules
        For each rule the largest sum of the radii over the distance of the centres; its first entry, and the end of
        all; entries of u, v and weight.
    total, kind, over
        Written: P float64; P int8, 0 if the exchange area is final, 1 if both patches are wholly in front of each
        other, but near, 2 if either crosses the other's plane; 2 x P x 4 heights of both over each other's plane.
    """
    points = np.empty((len(rules), 6))
    for pair in range(len(first)):
        patch, other = first[pair], second[pair]
        own, across = _plane(patch), _plane(other)
        low, high = _write_heights(patch, own, across, over[0, pair])
        others_low, others_high = _write_heights(other, across, own, over[1, pair])
        total[pair], kind[pair] = 0.0, 0
        if high <= 0 or others_high <= 0:
            continue
        if low < 0 or others_low < 0:
            kind[pair] = 2
            continue
        ratio = _nearness(patch, other)
        rule = 0
        while rule < len(limits) and ratio > limits[rule]:
            rule += 1
        if rule == len(limits):
            kind[pair] = 1
            continue
        for q in range(begin[rule], begin[rule + 1]):
            points[q, 0], points[q, 1], points[q, 2], points[q, 3], points[q, 4], points[q, 5] = _gauss_point(
                other, rules[q, 0], rules[q, 1], rules[q, 2])
        whole = 0.0
        for q in range(begin[rule], begin[rule + 1]):
            x, y, z, ax, ay, az = _gauss_point(patch, rules[q, 0], rules[q, 1], rules[q, 2])
            for r in range(begin[rule], begin[rule + 1]):
                dx, dy, dz = points[r, 0] - x, points[r, 1] - y, points[r, 2] - z
                square = dx * dx + dy * dy + dz * dz
                # Of two small areas: cos cos / (pi r^2) of both.
                whole += (dx * ax + dy * ay + dz * az) * -(
                    dx * points[r, 3] + dy * points[r, 4] + dz * points[r, 5]) / (np.pi * square * square)
        total[pair] = whole


@compiled
def _plane(patch):
    """X, y and z of a point of a patch's plane, of the normal, and how far from the plane a corner counts as in it.

    A quad whose coordinates were rounded is bent: its corners are above and below the plane by turns. What is no
    farther from a plane than the corners that define it is in front of it no more than behind it.
    """
    x, y, z = _middle(patch)
    ax, ay, az = patch[2, 0] - patch[0, 0], patch[2, 1] - patch[0, 1], patch[2, 2] - patch[0, 2]
    bx, by, bz = patch[3, 0] - patch[1, 0], patch[3, 1] - patch[1, 1], patch[3, 2] - patch[1, 2]
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    length = np.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx / length, ny / length, nz / length
    edge = _max_norm(patch, patch[0, 0], patch[0, 1], patch[0, 2])
    # The normal is across both diagonals: all four corners are as far away.
    bend = abs((patch[0, 0] - x) * nx + (patch[0, 1] - y) * ny + (patch[0, 2] - z) * nz)
    return x, y, z, nx, ny, nz, _IN_PLANE * edge + bend


@compiled
def _write_heights(patch, own, other, heights):
    """Write the distances of a patch's corners from the plane of another one, 0 of those that count as in it.

    Returns the least and the greatest of them.
    """
    x, y, z, nx, ny, nz, least = other
    least = _IN_PLANE * _max_norm(patch, x, y, z) + own[6] + least
    low, high = np.inf, -np.inf
    for corner in range(4):
        height = (patch[corner, 0] - x) * nx + (patch[corner, 1] - y) * ny + (patch[corner, 2] - z) * nz
        height *= abs(height) > least
        heights[corner] = height
        low, high = min(low, height), max(high, height)
    return low, high


@compiled
def _nearness(first, second):
    """Sum of the radii over the distance of the centres."""
    (x, y, z), (cx, cy, cz) = _middle(first), _middle(second)
    dx, dy, dz = x - cx, y - cy, z - cz
    return (_radius(first, x, y, z) + _radius(second, cx, cy, cz)) / max(
        np.sqrt(dx * dx + dy * dy + dz * dz), 1e-300)


@compiled
def _gauss_point(patch, u, v, weight):
    """A point of a patch and the vector of the area around it."""
    a, b, c, d = (1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v
    ux, uy, uz = _along_u(patch, 0, v), _along_u(patch, 1, v), _along_u(patch, 2, v)
    vx, vy, vz = _along_v(patch, 0, u), _along_v(patch, 1, u), _along_v(patch, 2, u)
    return (a * patch[0, 0] + b * patch[1, 0] + c * patch[2, 0] + d * patch[3, 0],
            a * patch[0, 1] + b * patch[1, 1] + c * patch[2, 1] + d * patch[3, 1],
            a * patch[0, 2] + b * patch[1, 2] + c * patch[2, 2] + d * patch[3, 2],
            weight * (uy * vz - uz * vy), weight * (uz * vx - ux * vz), weight * (ux * vy - uy * vx))


@compiled
def _middle(patch):
    """The mean of the four corners."""
    return ((patch[0, 0] + patch[1, 0] + patch[2, 0] + patch[3, 0]) / 4,
            (patch[0, 1] + patch[1, 1] + patch[2, 1] + patch[3, 1]) / 4,
            (patch[0, 2] + patch[1, 2] + patch[2, 2] + patch[3, 2]) / 4)


@compiled
def _max_norm(patch, x, y, z):
    """Largest maximum norm of the vectors from a point to the corners."""
    largest = 0.0
    for corner in range(4):
        largest = max(largest, abs(patch[corner, 0] - x), abs(patch[corner, 1] - y), abs(patch[corner, 2] - z))
    return largest


@compiled
def _radius(patch, x, y, z):
    """The distance of the farthest corner from a point."""
    largest = 0.0
    for corner in range(4):
        dx, dy, dz = patch[corner, 0] - x, patch[corner, 1] - y, patch[corner, 2] - z
        largest = max(largest, dx * dx + dy * dy + dz * dz)
    return np.sqrt(largest)


@compiled
def _along_u(patch, axis, v):
    """A coordinate of the bilinear map's derivative along u."""
    return (1 - v) * (patch[1, axis] - patch[0, axis]) + v * (patch[2, axis] - patch[3, axis])


@compiled
def _along_v(patch, axis, u):
    """A coordinate of the bilinear map's derivative along v."""
    return (1 - u) * (patch[3, axis] - patch[0, axis]) + u * (patch[2, axis] - patch[1, axis])
