"""Rays cast by Embree, as compiled functions: each is prepared in float64, and so is what Embree finds for it."""

from typing import NamedTuple

import numpy as np

from golden.cast.grid_kernel import dominant_axis, meet, position
from golden.compiled import callback, compiled
from golden.native import array, call, pointer, prefetch

__all__ = ["UNDECIDED", "Model", "cast", "find", "judge"]

UNDECIDED = -2
"""Number of the patch of a ray that another caster must decide."""

# Rays between which and the use of what Embree found for them the processor reads the patches found.
_BATCH = 32
# Words of eight bytes: Embree's arguments of a query, its context, which the state of a ray follows, and the ray; and a
# point with its context.
_ARGUMENTS, _STATE, _RAY, _POINT = 8, 24, 16, 24
# Words of the state, whole numbers: addresses of the scene's arrays, and what the query is.
_VERTICES, _PATCHES, _COUNT, _ANY, _SOURCE, _TARGET, _NORMALS = 2, 3, 4, 5, 6, 7, 22
# What the judge has found: a patch, and whether a ray passed beside one.
_FOUND, _BESIDE = 8, 9
# And float64: the ray, its limits, the best t, and the length of the direction where Embree's is about one.
_ORIGIN, _DIRECTION, _LEAST, _BEST, _UNIT, _BEGIN, _SLACK, _REACH = 10, 13, 16, 17, 18, 19, 20, 21
# Words of four bytes of Embree's ray.
_END, _MASK, _MET, _GEOMETRY = 8, 9, 17, 18
# What has no number, in 32 bits.
_NONE = np.uint32(0xFFFFFFFF)
# All that a query may use, and that its arguments have a filter, as the flags of the arguments.
_WITH_FILTER, _WITHOUT = (0xFFFFFFFF << 32) | 2, 0xFFFFFFFF << 32
# Embree's largest float32 of all.
_FAR = 3e38


class Model(NamedTuple):
    """A scene in Embree's memory, and what judges the hits.

    Parameters
    ----------
    nearest, blocked, around, judge, find
        Addresses of Embree's three queries, of `judge`, and of `find`.
    scene
        Address of its scene: the patches, moved by ``-centre`` and divided by ``size``, somewhat widened.
    centre, size
        3 float64 and float64.
    rise, back, slack, reach
        In the scene's sizes: how far a ray starts above its source, how far behind that a hit may be, how much less
        deep than another a hit is if Embree separates them, and how near a patch is that may be at a start.
    least
        Least distance of a hit, in scene units.
    vertices
        N x 4 x 3 float64 corners.
    patches
        N x 4 float32: the number of the surface as int32, 1 for a triangle, the share of a patch that is near its
        border, and the least product of that share and of Embree's normal and direction for a hit to count untested.
    normals
        A normal for each number of a surface, S x 3.
    """

    nearest: int
    blocked: int
    around: int
    judge: int
    find: int
    scene: int
    centre: np.ndarray
    size: float
    rise: float
    back: float
    slack: float
    reach: float
    least: float
    vertices: np.ndarray
    patches: np.ndarray
    normals: np.ndarray


@callback
def judge(arguments):
    """What Embree calls with each patch that it finds: another one than a ray's own counts if the oracle says so.

    A patch that the ray hits between its middle and the band of float32 along its border counts at once, if any patch
    will do.
    """
    valid, found = pointer(arguments[0], np.int32), pointer(arguments[4], np.float32)
    whole, real = pointer(arguments[2], np.int64), pointer(arguments[2], np.float64)
    ray = pointer(arguments[3], np.float32)
    patch = np.intp(pointer(arguments[4], np.int32)[5])
    fields = pointer(np.uintp(whole[_PATCHES]), np.float32)
    surface = pointer(np.uintp(whole[_PATCHES]), np.int32)[4 * patch]
    if surface == whole[_SOURCE] or surface == whole[_TARGET]:
        valid[0] = 0
        return
    if whole[_ANY] != 0:
        u, v = found[3], found[4]
        inner = min(u, v, 1 - u - v) if fields[4 * patch + 1] != 0 else min(u, v, 1 - u, 1 - v)
        slope = abs(found[0] * ray[4] + found[1] * ray[5] + found[2] * ray[6])
        if inner * slope > fields[4 * patch + 3] and real[_SLACK] < ray[_END] < (
                real[_BEST] * real[_UNIT] - real[_BEGIN] - real[_SLACK]):
            whole[_FOUND] = patch
            return
    vertices = array(pointer(np.uintp(whole[_VERTICES]), np.float64), (whole[_COUNT], 4, 3))
    kz = dominant_axis(real[_DIRECTION], real[_DIRECTION + 1], real[_DIRECTION + 2])
    kx, ky = (kz + 1) % 3, (kz + 2) % 3
    scale = real[_DIRECTION + kz]
    met, depth = meet(vertices, patch, fields[4 * patch + 1] != 0, kx, ky, kz, real[_ORIGIN + kx], real[_ORIGIN + ky],
                      real[_ORIGIN + kz], real[_DIRECTION + kx] / scale, real[_DIRECTION + ky] / scale)
    t = depth * (1 / scale)
    if not met:
        whole[_BESIDE] = 1
    elif t > real[_LEAST] and (t < real[_BEST] or (t == real[_BEST] and patch < whole[_FOUND])):
        real[_BEST], whole[_FOUND] = t, patch
        # Embree goes on to those that are nearly as near.
        ray[_END] = np.float32(t * real[_UNIT] - real[_BEGIN] + real[_SLACK])
        return
    valid[0] = 0


@callback
def find(arguments):
    """What Embree calls with each patch whose box is near a point: whether that is another one than the point's own."""
    whole, real = pointer(arguments[1], np.int64), pointer(arguments[1], np.float64)
    patch = np.intp(arguments[2] & 0xFFFFFFFF)
    surface = pointer(np.uintp(whole[_PATCHES]), np.int32)[4 * patch]
    if surface != whole[_SOURCE] and surface != whole[_TARGET]:
        corner = pointer(np.uintp(whole[_VERTICES]), np.float64)
        normal = pointer(np.uintp(whole[_NORMALS]), np.float64)
        height = 0.0
        for axis in range(3):
            height += normal[3 * surface + axis] * (real[_ORIGIN + axis] - corner[12 * patch + axis])
        if abs(height) < real[_REACH]:
            whole[_BESIDE] = 1
    return False


@compiled
def cast(model, any_hit, origin, direction, source, target, tmax, patch_of, t_of, u_of, v_of):
    """Cast R rays.

    Parameters
    ----------
    model
        The scene.
    any_hit
        Any hit will do.
    origin, direction, source, target, tmax
        The rays, see `golden.cast.rays.Rays`.
    patch_of, t_of, u_of, v_of
        The hits, see `golden.cast.rays.Hits`, which are written; `UNDECIDED` for the patch of a ray that passes beside
        one of which it has no hit. With ``any_hit`` the others may be empty.
    """
    memory = np.zeros(_ARGUMENTS + _STATE + _RAY + _POINT + 8, dtype=np.int64)
    # As the lines of a cache.
    arguments = memory[(-memory.ctypes.data) % 64 // 8:]
    whole = arguments[_ARGUMENTS:_ARGUMENTS + _STATE]
    arguments[1], arguments[2] = whole.ctypes.data, model.judge
    # No instance.
    whole[0] = -1
    whole[_VERTICES], whole[_PATCHES] = model.vertices.ctypes.data, model.patches.ctypes.data
    whole[_COUNT], whole[_ANY], whole.view(np.float64)[_SLACK] = len(model.vertices), any_hit, model.slack
    whole[_NORMALS], whole.view(np.float64)[_REACH] = model.normals.ctypes.data, model.reach * model.size
    rows = np.empty(_BATCH, dtype=np.int64)
    for begin in range(0, len(origin), _BATCH):
        count = min(_BATCH, len(origin) - begin)
        for number in range(count):
            rows[number] = begin + number
        judged = any_hit
        while count > 0:
            arguments[0] = _WITH_FILTER if judged else _WITHOUT
            _query(model, any_hit, judged, rows[:count], origin, direction, source, target, tmax, arguments, patch_of)
            # Nobody needs to know where an obstacle is.
            if len(t_of) == 0:
                break
            count = _locate(model, judged, rows[:count], origin, direction, source, target, tmax, patch_of, t_of, u_of,
                            v_of)
            judged = True


@compiled
def _query(model, any_hit, judged, rows, origin, direction, source, target, tmax, arguments, patch_of):
    """Have Embree cast some rays, and write the patches found."""
    whole = arguments[_ARGUMENTS:_ARGUMENTS + _STATE]
    real, ray = whole.view(np.float64), arguments[_ARGUMENTS + _STATE:_ARGUMENTS + _STATE + _RAY].view(np.float32)
    bits, at = ray.view(np.uint32), arguments.ctypes.data
    query, share = model.blocked if any_hit else model.nearest, 1 / model.size
    cx, cy, cz = model.centre[0], model.centre[1], model.centre[2]
    at_patch, last = False, -1
    for row in rows:
        ox, oy, oz = origin[row, 0], origin[row, 1], origin[row, 2]
        dx, dy, dz = direction[row, 0], direction[row, 1], direction[row, 2]
        largest = max(abs(dx), abs(dy), abs(dz))
        if judged:
            real[_ORIGIN], real[_ORIGIN + 1], real[_ORIGIN + 2] = ox, oy, oz
            real[_DIRECTION], real[_DIRECTION + 1], real[_DIRECTION + 2] = dx, dy, dz
            real[_LEAST], real[_BEST] = model.least / np.sqrt(dx * dx + dy * dy + dz * dz), tmax[row]
            whole[_SOURCE], whole[_TARGET], whole[_FOUND], whole[_BESIDE] = source[row], target[row], -1, 0
        # Rays of one start are looked after together.
        if last < 0 or not _same(origin, last, row) or source[last] != source[row]:
            at_patch = False
            if row + 1 < len(origin) and _same(origin, row, row + 1):
                real[_ORIGIN], real[_ORIGIN + 1], real[_ORIGIN + 2] = ox, oy, oz
                whole[_SOURCE], whole[_TARGET], whole[_BESIDE] = source[row], target[row], 0
                point = arguments[_ARGUMENTS + _STATE + _RAY:].view(np.float32)
                point[0], point[1], point[2], point[3] = (ox - cx) * share, (oy - cy) * share, (oz - cz) * share, 0
                point[4] = 2 * model.reach
                # No instances.
                context = arguments[_ARGUMENTS + _STATE + _RAY + 4:].view(np.uint32)
                context[32], context[33], context[34], context[35] = _NONE, 0, 0, 0
                call(model.around, (np.uintp(model.scene), point.ctypes.data, context.ctypes.data,
                                    np.uintp(model.find), whole.ctypes.data))
                at_patch = whole[_BESIDE] != 0
                whole[_BESIDE] = 0
        last = row
        inverse = 1 / largest
        dx, dy, dz = dx * inverse, dy * inverse, dz * inverse
        px, py, pz = (ox - cx) * share, (oy - cy) * share, (oz - cz) * share
        own, begin, unit = source[row], 0.0, largest * share
        if 0 <= own < len(model.normals):
            nx, ny, nz = model.normals[own, 0], model.normals[own, 1], model.normals[own, 2]
            rise = model.rise if nx * dx + ny * dy + nz * dz > 0 else -model.rise
            px, py, pz = px + rise * nx, py + rise * ny, pz + rise * nz
        if max(abs(px), abs(py), abs(pz)) > 1:
            # A ray from outside starts two of the scene's sizes before its middle: float32 keeps no more of it.
            begin = max((px * dx + py * dy + pz * dz) / -(dx * dx + dy * dy + dz * dz) - 2, 0.0)
            px, py, pz = px + begin * dx, py + begin * dy, pz + begin * dz
        ray[0], ray[1], ray[2], ray[3] = px, py, pz, -model.back
        ray[4], ray[5], ray[6], ray[7] = dx, dy, dz, 0
        ray[_END] = min(tmax[row] * unit - begin + model.slack, _FAR)
        bits[_MASK], bits[10], bits[11], bits[_GEOMETRY], bits[19], bits[20] = _NONE, 0, 0, _NONE, _NONE, _NONE
        if judged:
            real[_UNIT], real[_BEGIN] = unit, begin
        patch = UNDECIDED if at_patch else -1
        if not at_patch and ray[_END] > 0 and max(abs(px), abs(py), abs(pz)) < 4:
            call(query, (np.uintp(model.scene), ray.ctypes.data, at))
            if judged:
                patch = whole[_FOUND]
                if whole[_BESIDE] != 0 and (patch < 0 or not any_hit):
                    patch = UNDECIDED
            elif bits[_GEOMETRY] != _NONE:
                patch = np.int64(bits[_MET])
        patch_of[row] = patch
        if patch >= 0:
            line = model.vertices.ctypes.data + np.uintp(96 * patch)
            prefetch(line)
            prefetch(line + np.uintp(95))
            prefetch(model.patches.ctypes.data + np.uintp(16 * patch))


@compiled
def _same(origin, one, other):
    """Whether two rays start at one point."""
    return (origin[one, 0] == origin[other, 0] and origin[one, 1] == origin[other, 1]
            and origin[one, 2] == origin[other, 2])


@compiled
def _locate(model, judged, rows, origin, direction, source, target, tmax, patch_of, t_of, u_of, v_of):
    """Write where rays hit the patches found; the number of hits that must be judged, whose rows are moved to front."""
    unsure, surfaces = 0, model.patches.view(np.int32)
    for row in rows:
        patch, t, u, v = patch_of[row], np.inf, 0.0, 0.0
        if patch >= 0:
            kz = dominant_axis(direction[row, 0], direction[row, 1], direction[row, 2])
            kx, ky = (kz + 1) % 3, (kz + 2) % 3
            ox, oy, oz = origin[row, kx], origin[row, ky], origin[row, kz]
            along = direction[row, kz]
            sx, sy = direction[row, kx] / along, direction[row, ky] / along
            triangle, border = model.patches[patch, 1] != 0, model.patches[patch, 2]
            met, depth = meet(model.vertices, patch, triangle, kx, ky, kz, ox, oy, oz, sx, sy)
            t = depth * (1 / along)
            u, v = position(model.vertices, patch, triangle, kx, ky, kz, ox, oy, oz, sx, sy)
            if not judged:
                across = u * (1 - v) if triangle else u
                beyond = (1 - u) * (1 - v) if triangle else min(1 - u, 1 - v)
                own = surfaces[patch, 0] == source[row] or surfaces[patch, 0] == target[row]
                if own or not (met and min(across, beyond, v) > border and t < tmax[row]
                               and t * abs(along) > model.slack * model.size):
                    rows[unsure] = row
                    unsure += 1
        t_of[row], u_of[row], v_of[row] = t, u, v
    return unsure
