"""Object tests: where a ray hits an object, and whether the surface of an object meets a box."""

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.torus.torus_scene import Objects

__all__ = ["NEAREST", "hit_distance", "meets_box"]

NEAREST = 1e-7
"""Least distance of a hit, so that a ray does not hit where it starts; directions are unit vectors."""


@compiled
def hit_distance(objects: Objects, number: int, origin: np.ndarray, direction: np.ndarray) -> float:
    """Distance along a ray to an object, infinite without a hit.

    The whole object is tested with the ray's own origin, so that all nodes compute the same bits.
    """
    corners, count = objects.corners[number], objects.counts[number]
    if count == 0:
        radius = corners[1, 0]
        along = square = 0.0
        for axis in range(3):
            to = corners[0, axis] - origin[axis]
            along += to * direction[axis]
            square += to * to
        root = along * along - square + radius * radius
        if root < 0:
            return np.inf
        root = np.sqrt(root)
        if along - root > NEAREST:
            return along - root
        return along + root if along + root > NEAREST else np.inf
    normal = objects.normals[number]
    height = slope = 0.0
    for axis in range(3):
        height += (corners[0, axis] - origin[axis]) * normal[axis]
        slope += direction[axis] * normal[axis]
    if slope == 0:
        return np.inf
    distance = height / slope
    if not distance > NEAREST:
        return np.inf
    for corner in range(count):
        after = corner + 1 if corner + 1 < count else 0
        side = 0.0
        for axis in range(3):
            # The edge turned into the polygon: normal x edge.
            one, two = (axis + 1) % 3, (axis + 2) % 3
            inward = (normal[one] * (corners[after, two] - corners[corner, two])
                      - normal[two] * (corners[after, one] - corners[corner, one]))
            side += inward * (origin[axis] + distance * direction[axis] - corners[corner, axis])
        if side < 0:
            return np.inf
    return distance


@compiled
def meets_box(objects: Objects, number: int, low: np.ndarray, high: np.ndarray) -> bool:
    """Whether an object's surface meets a closed box. A box within a sphere does not.

    Polygons are separated from boxes by faces of the box, the plane of the polygon, or an edge of each.
    """
    corners, count = objects.corners[number], objects.counts[number]
    if count == 0:
        near = far = 0.0
        for axis in range(3):
            below, above = low[axis] - corners[0, axis], high[axis] - corners[0, axis]
            to = max(below, -above, 0.0)
            near += to * to
            to = max(abs(below), abs(above))
            far += to * to
        square = corners[1, 0] * corners[1, 0]
        return near <= square <= far
    for axis in range(3):
        least = most = corners[0, axis]
        for corner in range(1, count):
            least, most = min(least, corners[corner, axis]), max(most, corners[corner, axis])
        if least > high[axis] or most < low[axis]:
            return False
    normal = objects.normals[number]
    if _separates(corners, 1, low, high, normal[0], normal[1], normal[2]):
        return False
    for corner in range(count):
        after = corner + 1 if corner + 1 < count else 0
        x, y, z = (corners[after, 0] - corners[corner, 0], corners[after, 1] - corners[corner, 1],
                   corners[after, 2] - corners[corner, 2])
        if (_separates(corners, count, low, high, 0.0, -z, y) or _separates(corners, count, low, high, z, 0.0, -x)
                or _separates(corners, count, low, high, -y, x, 0.0)):
            return False
    return True


@compiled
def _separates(corners, count, low, high, x, y, z):
    """Whether the first corners and a box do not overlap along a direction."""
    centre = (x * (low[0] + high[0]) + y * (low[1] + high[1]) + z * (low[2] + high[2])) / 2
    reach = (abs(x) * (high[0] - low[0]) + abs(y) * (high[1] - low[1]) + abs(z) * (high[2] - low[2])) / 2
    least = most = x * corners[0, 0] + y * corners[0, 1] + z * corners[0, 2]
    for corner in range(1, count):
        at = x * corners[corner, 0] + y * corners[corner, 1] + z * corners[corner, 2]
        least, most = min(least, at), max(most, at)
    return least > centre + reach or most < centre - reach
