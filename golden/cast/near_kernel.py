"""Patches of a scene in Embree's memory that others lie upon or close above, by compiled functions."""

import numpy as np

from golden.base.compiled import callback, compiled
from golden.base.native import array, call, pointer

__all__ = ["OVER", "UNDER", "UPON", "compare", "find_near"]

UPON, OVER, UNDER = 1, 2, 4
"""Bits of `find_near`."""

# Words of eight bytes: a point with its context, then the arguments: addresses of the corners and normals of patches,
# of how many, a patch of them, what has been found about it; and, float64, its limits, and the box of what is above it.
_POINT, _STATE = 24, 14
_VERTICES, _NORMALS, _COUNT, _OWN, _FOUND, _BAND, _LEAST, _TOUCH, _BOX = range(9)
# Cosine of the angle between planes from which patches that cross or meet are close to each other farther from there
# than float32's band.
_ALONG = 0.97
# What has no number, in 32 bits.
_NONE = np.uint32(0xFFFFFFFF)


@callback
def compare(arguments):
    """What Embree calls with each patch whose box is near another one: what that is to it."""
    whole, real = pointer(arguments[1], np.int64), pointer(arguments[1], np.float64)
    own, other = whole[_OWN], np.intp(arguments[2] & 0xFFFFFFFF)
    if other == own:
        return False
    shape = (whole[_COUNT], 4, 3)
    vertices = array(pointer(np.uintp(whole[_VERTICES]), np.float64), shape)
    normals = array(pointer(np.uintp(whole[_NORMALS]), np.float64), (whole[_COUNT], 3))
    cosine = 0.0
    for axis in range(3):
        cosine += normals[own, axis] * normals[other, axis]
    if abs(cosine) <= _ALONG:
        return False
    low, high = np.inf, -np.inf
    for corner in range(4):
        height = 0.0
        for axis in range(3):
            height += normals[own, axis] * (vertices[other, corner, axis] - vertices[own, 0, axis])
        low, high = min(low, height), max(high, height)
    if low > real[_BAND] or high < -real[_BAND]:
        return False
    if _beside(vertices, normals, own, other, real[_TOUCH]) or _beside(vertices, normals, other, own, real[_TOUCH]):
        return False
    whole[_FOUND] |= UPON | (OVER if high > real[_LEAST] else 0) | (UNDER if low < -real[_LEAST] else 0)
    if max(-low, high) > real[_LEAST]:
        for corner in range(4):
            for axis in range(3):
                place = _BOX + axis
                real[place] = min(real[place], vertices[other, corner, axis])
                real[place + 3] = max(real[place + 3], vertices[other, corner, axis])
    return False


@compiled
def _beside(vertices, normals, one, other, touch):
    """Whether a plane upright on an edge of the one patch has the other one outside, but for ``touch``."""
    nx, ny, nz = normals[one, 0], normals[one, 1], normals[one, 2]
    for corner in range(4):
        after = (corner + 1) % 4
        ax, ay, az = vertices[one, corner, 0], vertices[one, corner, 1], vertices[one, corner, 2]
        ex, ey, ez = vertices[one, after, 0] - ax, vertices[one, after, 1] - ay, vertices[one, after, 2] - az
        length = np.sqrt(ex * ex + ey * ey + ez * ez)
        ix, iy, iz = ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex
        farthest = -np.inf
        for point in range(4):
            farthest = max(farthest, ix * (vertices[other, point, 0] - ax) + iy * (vertices[other, point, 1] - ay)
                           + iz * (vertices[other, point, 2] - az))
        if length > 0 and farthest <= touch * length:
            return True
    return False


@compiled
def find_near(query, compare_at, scene, centre, size, vertices, normals, band, least, touch, near, boxes):
    """Write where others are near each patch: `UPON` it, and of those not in its plane `OVER` its front or `UNDER` it.

    Patches of planes at more than 14 degrees, and those whose borders just meet, do not count.

    Parameters
    ----------
    query, compare_at
        Addresses of Embree's query of points, and of `compare`.
    scene, centre, size, vertices
        See `golden.cast.embree_kernel.Model`.
    normals
        N x 3.
    band, least, touch
        In scene units: how near patches are that lie over others, how far from a plane those are that are in it, and
        by how much patches reach into each other that just meet.
    near, boxes
        N uint8, and N x 6, the lower and upper corners of the boxes of what is over and under the patches, which are
        written.
    """
    memory = np.zeros(_POINT + _STATE + 8, dtype=np.int64)
    words = memory[(-memory.ctypes.data) % 64 // 8:]
    # Pointers and single numbers: views and slices are checked, with messages that take long to compile.
    at = np.uintp(words.ctypes.data)
    whole_at, context_at = at + np.uintp(8 * _POINT), at + np.uintp(8 * 4)
    point, context = pointer(at, np.float32), pointer(context_at, np.uint32)
    whole, real = pointer(whole_at, np.int64), pointer(whole_at, np.float64)
    whole[_VERTICES], whole[_NORMALS], whole[_COUNT] = vertices.ctypes.data, normals.ctypes.data, len(vertices)
    real[_BAND], real[_LEAST], real[_TOUCH] = band, least, touch
    # No instances.
    context[32], context[33], context[34], context[35] = _NONE, 0, 0, 0
    for patch in range(len(vertices)):
        reach = 0.0
        for axis in range(3):
            low = min(vertices[patch, 0, axis], vertices[patch, 1, axis], vertices[patch, 2, axis],
                      vertices[patch, 3, axis])
            high = max(vertices[patch, 0, axis], vertices[patch, 1, axis], vertices[patch, 2, axis],
                       vertices[patch, 3, axis])
            point[axis] = ((low + high) / 2 - centre[axis]) / size
            reach += (high - low) * (high - low)
            real[_BOX + axis], real[_BOX + axis + 3] = np.inf, -np.inf
        point[3], point[4] = 0, (np.sqrt(reach) / 2 + 2 * band) / size
        whole[_OWN], whole[_FOUND] = patch, 0
        # The words are named here, or their memory would be freed.
        call(query, (np.uintp(scene), np.uintp(words.ctypes.data), context_at, np.uintp(compare_at), whole_at))
        near[patch] = whole[_FOUND]
        for place in range(6):
            boxes[patch, place] = real[_BOX + place]
