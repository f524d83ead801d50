"""Rays cast by Embree, as compiled functions: each is prepared in float64, and so is what Embree finds for it."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import callback, compiled, inlined
from golden.base.native import array, call, pointer, prefetch
from golden.cast.patch_kernel import coordinates, dominant_axis, inside, meet, position, sheared

__all__ = ["LOW_BACK", "LOW_FRONT", "Model", "cast", "judge"]

LOW_FRONT, LOW_BACK = 1, 2
"""Notes on a surface: another patch may be above rays on its front or on its back."""


# Number of the patch of a ray that must be judged.
_UNSURE = -2
# Rays between which and the use of what Embree found for them the processor reads the patches found.
_BATCH = 128
# Words of eight bytes: Embree's arguments of a query; from where on, its context, which the state of a ray follows, the
# ray, which rays of a packet are cast, and the packet; and all of them.
_ARGUMENTS, _STATE, _RAY_AT, _VALID_AT, _PACKET_AT, _WORDS = 8, 24, 32, 48, 56, 144
# Words of the state, whole numbers: addresses of the scene's arrays, and what the query is.
_VERTICES, _PATCHES, _COUNT, _GOAL, _SOURCE, _TARGET = 2, 3, 4, 5, 6, 7
# What the judge has found: a patch, and whether a ray passed beside one.
_FOUND, _BESIDE = 8, 9
# And float64: the ray, its limits, the best t, and the length of the direction where Embree's is about one.
_ORIGIN, _DIRECTION, _LEAST, _BEST, _UNIT, _BEGIN, _SLACK = 10, 13, 16, 17, 18, 19, 20
# What a query is to find: the nearest hit, any, or the nearest of all that a ray meets up to its end.
_NEAREST, _ANY, _ALL = 0, 1, 2
# Words of four bytes of Embree's ray.
_END, _MASK, _MET, _GEOMETRY = 8, 9, 17, 18
# What has no number, in 32 bits.
_NONE = np.uint32(0xFFFFFFFF)
# All that a query may use, and that its arguments have a filter, as the flags of the arguments.
_WITH_FILTER, _WITHOUT = (0xFFFFFFFF << 32) | 2, 0xFFFFFFFF << 32
# That rays of a packet go on together, how many there are, and between which largest components of directions they do.
_COHERENT, _LANES, _NARROW = 1 << 16, 8, 0.125
# Embree's largest float32 of all.
_FAR = 3e38
# Rows of a batch's hits: the rays' origins and directions, dominant axis last, the patches' corners, whether they are
# triangles, the hits' t, u and v, whether they are sure, and what for: how far from the border, and the largest t.
_CORNERS, _TRIANGLE, _T, _U, _V, _SURE, _BORDER, _MOST, _ROWS = 6, 18, 19, 20, 21, 22, 23, 24, 25


class Model(NamedTuple):
    """A scene in Embree's memory, and what judges the hits.

    Parameters
    ----------
    nearest, together, blocked, judge
        Addresses of Embree's queries, of a ray, of a packet and of any hit, and of `judge`.
    scene
        Address of its scene: the patches, moved by ``-centre`` and divided by ``size``, somewhat widened.
    x, y, z, size
        The scene's centre and size.
    back, before, slack
        In the scene's sizes: how far before its start a ray from above its source begins for Embree, and any other one,
        and how much less deep than another a hit is if Embree separates them.
    least
        Least distance of a hit, in scene units.
    count, surfaces
        How many patches there are, N, and how many surfaces, S.
    vertices
        Address of N x 4 x 3 float64 corners; numbers alone cost nothing to hand on.
    patches
        Address of N x 4 float32: the number of the surface as int32, 1 for a triangle, the share of a patch that is
        near its border, and the least product of that share and of Embree's normal and direction for a hit to count
        untested.
    rises
        Address of S x 4 float32: how rays rise from each surface that start on its front, in the scene's sizes, and the
        sum of the notes on it.
    zones
        Address of S x 6 float64: lower and upper corner of the box in which patches lie along each surface with notes.
        Of a ray that starts there every patch that Embree finds is judged.
    normals
        Address of those of the patches, N x 3 float64.
    behind
        Address of the patch back to back with each one, or itself, N int32; 0 if there is no such pair.
    """

    nearest: int
    together: int
    blocked: int
    judge: int
    scene: int
    x: float
    y: float
    z: float
    size: float
    back: float
    before: float
    slack: float
    least: float
    count: int
    surfaces: int
    vertices: int
    patches: int
    rises: int
    zones: int
    normals: int
    behind: int


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
    if whole[_GOAL] == _ANY:
        u, v = found[3], found[4]
        inner = min(u, v, 1 - u - v) if fields[4 * patch + 1] != 0 else min(u, v, 1 - u, 1 - v)
        slope = abs(found[0] * ray[4] + found[1] * ray[5] + found[2] * ray[6])
        if inner * slope > fields[4 * patch + 3] and real[_SLACK] < ray[_END] + real[_BEGIN] and ray[_END] < (
                real[_BEST] * real[_UNIT] - real[_BEGIN] - real[_SLACK]):
            whole[_FOUND] = patch
            return
    vertices = array(pointer(np.uintp(whole[_VERTICES]), np.float64), (whole[_COUNT], 4, 3))
    kz = dominant_axis(real[_DIRECTION], real[_DIRECTION + 1], real[_DIRECTION + 2])
    kx, ky = (kz + 1) % 3, (kz + 2) % 3
    scale = real[_DIRECTION + kz]
    met, depth = meet(vertices, patch, kx, ky, kz, real[_ORIGIN + kx], real[_ORIGIN + ky], real[_ORIGIN + kz],
                      real[_DIRECTION + kx] / scale, real[_DIRECTION + ky] / scale)
    t = depth * (1 / scale)
    if not met:
        whole[_BESIDE] = 1
    elif t > real[_LEAST] and (t < real[_BEST] or (t == real[_BEST] and patch < whole[_FOUND])):
        real[_BEST], whole[_FOUND] = t, patch
        if whole[_GOAL] != _ALL:
            # Embree goes on to those that are nearly as near.
            ray[_END] = np.float32(t * real[_UNIT] - real[_BEGIN] + real[_SLACK])
            return
    valid[0] = 0


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
        The hits, see `golden.cast.rays.Hits`, which are written. If the last three are empty, they are not.
    """
    memory = np.zeros(_WORDS + 8, dtype=np.int64)
    # As the lines of a cache.
    arguments = memory[(-memory.ctypes.data) % 64 // 8:]
    whole = arguments[_ARGUMENTS:_ARGUMENTS + _STATE]
    arguments[1], arguments[2] = whole.ctypes.data, model.judge
    # No instance.
    whole[0] = -1
    whole[_VERTICES], whole[_PATCHES], whole[_COUNT] = model.vertices, model.patches, model.count
    pointer(np.uintp(whole.ctypes.data), np.float64)[_SLACK] = model.slack
    rows, hits = np.empty(_BATCH, dtype=np.int64), np.empty((_ROWS, _BATCH))
    for begin in range(0, len(origin), _BATCH):
        count = min(_BATCH, len(origin) - begin)
        for number in range(count):
            rows[number] = begin + number
        judged = any_hit
        while count > 0:
            if judged:
                _judge_each(model, _ANY if any_hit else _NEAREST, rows[:count], origin, direction, source, target, tmax,
                            arguments, patch_of)
            else:
                _find_each(model, rows[:count], origin, direction, source, tmax, arguments, patch_of)
            # Nobody needs to know where an obstacle is.
            if any_hit and len(t_of) == 0:
                break
            _locate(model, rows[:count], origin, direction, source, target, tmax, patch_of, hits)
            count = _write(model, judged, any_hit, rows[:count], hits, origin, direction, patch_of, t_of, u_of, v_of)
            judged = True


@inlined
def _aim(model, may_rise, ray, lanes, row, origin, direction, source, tmax):
    """Prepare a ray: whether Embree may find its source, where it begins, and the length of Embree's direction in t.

    Parameters
    ----------
    may_rise
        It may start above its source.
    ray, lanes
        The address in a packet of so many rays.
    """
    bits, real, share = pointer(ray, np.uint32), pointer(ray, np.float32), 1 / model.size
    dx, dy, dz = direction[row, 0], direction[row, 1], direction[row, 2]
    largest = max(abs(dx), abs(dy), abs(dz))
    inverse = 1 / largest
    dx, dy, dz = dx * inverse, dy * inverse, dz * inverse
    px, py, pz = origin[row, 0] - model.x, origin[row, 1] - model.y, origin[row, 2] - model.z
    px, py, pz = px * share, py * share, pz * share
    own, begin, unit, low = source[row], -model.before, largest * share, False
    if 0 <= own < model.surfaces:
        rise = pointer(np.uintp(model.rises + 16 * own), np.float32)
        nx, ny, nz = np.float64(rise[0]), np.float64(rise[1]), np.float64(rise[2])
        # No branch, as nobody can foresee it.
        side = np.copysign(1.0, nx * dx + ny * dy + nz * dz)
        low = rise[3] != 0 and _is_low(model.zones + 48 * own, np.intp(rise[3]), side, origin[row, 0], origin[row, 1],
                                         origin[row, 2])
        if may_rise and not low:
            begin = -model.back
            px, py, pz = px + side * nx, py + side * ny, pz + side * nz
    if max(abs(px), abs(py), abs(pz)) > 1:
        # A ray from outside starts two of the scene's sizes before its middle: float32 keeps no more of it.
        begin = max((px * dx + py * dy + pz * dz) / -(dx * dx + dy * dy + dz * dz) - 2, begin)
    real[0], real[lanes], real[2 * lanes] = px + begin * dx, py + begin * dy, pz + begin * dz
    real[3 * lanes], real[7 * lanes] = 0, 0
    real[4 * lanes], real[5 * lanes], real[6 * lanes] = dx, dy, dz
    real[_END * lanes] = min(tmax[row] * unit - begin + model.slack, _FAR)
    bits[_MASK * lanes], bits[10 * lanes], bits[11 * lanes] = _NONE, 0, 0
    bits[_GEOMETRY * lanes], bits[19 * lanes], bits[20 * lanes] = _NONE, _NONE, _NONE
    return low, begin, unit


@compiled
def _is_low(zone, notes, side, x, y, z):
    """Whether another patch may be above a ray that starts on the front or the back of a surface."""
    box = pointer(np.uintp(zone), np.float64)
    return (notes & (LOW_FRONT if side > 0 else LOW_BACK) != 0
            and box[0] <= x <= box[3] and box[1] <= y <= box[4] and box[2] <= z <= box[5])


@inlined
def _passes(ray, lanes):
    """Whether a ray may meet the scene."""
    real = pointer(ray, np.float32)
    return real[_END * lanes] > 0 and max(abs(real[0]), abs(real[lanes]), abs(real[2 * lanes])) < 4


@inlined
def _together(origin, direction, one, other):
    """Whether two rays start at one point in nearly the same direction."""
    dx, dy, dz = direction[one, 0], direction[one, 1], direction[one, 2]
    away = max(abs(direction[other, 0] - dx), abs(direction[other, 1] - dy), abs(direction[other, 2] - dz))
    return (away < _NARROW * max(abs(dx), abs(dy), abs(dz)) and origin[one, 0] == origin[other, 0]
            and origin[one, 1] == origin[other, 1] and origin[one, 2] == origin[other, 2])


@compiled
def _find_each(model, rows, origin, direction, source, tmax, arguments, patch_of):
    """Write the patches that Embree finds first along rays, or that they must be judged."""
    at, done = np.uintp(arguments.ctypes.data), 0
    ray = at + np.uintp(8 * _RAY_AT)
    while done < len(rows):
        last = done + _LANES - 1
        if last < len(rows) and _together(origin, direction, rows[done], rows[last]):
            _find_packet(model, rows[done:last + 1], origin, direction, source, tmax, at, patch_of)
            done += _LANES
            continue
        row = rows[done]
        done += 1
        if done < len(rows):
            prefetch(np.uintp(model.rises + 16 * max(source[rows[done]], 0)))
        low, _, _ = _aim(model, True, ray, 1, row, origin, direction, source, tmax)
        if low:
            patch_of[row] = _UNSURE
            continue
        patch_of[row] = -1
        if _passes(ray, 1):
            arguments[0] = _WITHOUT
            call(model.nearest, (np.uintp(model.scene), ray, at))
            _take(model, ray, 1, row, patch_of)


@compiled
def _find_packet(model, rows, origin, direction, source, tmax, at, patch_of):
    """The same of rays that Embree casts together."""
    pointer(at, np.int64)[0] = _WITHOUT | _COHERENT
    packet, cast_of = at + np.uintp(8 * _PACKET_AT), pointer(at + np.uintp(8 * _VALID_AT), np.int32)
    for lane in range(_LANES):
        ray = packet + np.uintp(4 * lane)
        low, _, _ = _aim(model, True, ray, _LANES, rows[lane], origin, direction, source, tmax)
        patch_of[rows[lane]] = _UNSURE if low else -1
        cast_of[lane] = -1 if not low and _passes(ray, _LANES) else 0
    call(model.together, (at + np.uintp(8 * _VALID_AT), np.uintp(model.scene), packet, at))
    for lane in range(_LANES):
        if cast_of[lane] != 0:
            _take(model, packet + np.uintp(4 * lane), _LANES, rows[lane], patch_of)


@inlined
def _take(model, ray, lanes, row, patch_of):
    """Write the patch that Embree has found, if it has found any."""
    bits = pointer(ray, np.uint32)
    if bits[_GEOMETRY * lanes] != _NONE:
        patch = np.intp(bits[_MET * lanes])
        patch_of[row] = patch
        prefetch(np.uintp(model.vertices + 96 * patch))
        prefetch(np.uintp(model.vertices + 96 * patch + 95))
        prefetch(np.uintp(model.patches + 16 * patch))


@compiled
def _judge_each(model, goal, rows, origin, direction, source, target, tmax, arguments, patch_of):
    """Write the patches that rays hit, each that Embree finds judged; of a ray that passes beside one, all along it."""
    arguments[0], at = _WITH_FILTER, np.uintp(arguments.ctypes.data)
    ray = at + np.uintp(8 * _RAY_AT)
    whole, real = pointer(at + np.uintp(8 * _ARGUMENTS), np.int64), pointer(at + np.uintp(8 * _ARGUMENTS), np.float64)
    for row in rows:
        dx, dy, dz = direction[row, 0], direction[row, 1], direction[row, 2]
        real[_LEAST] = model.least / np.sqrt(dx * dx + dy * dy + dz * dz)
        real[_DIRECTION], real[_DIRECTION + 1], real[_DIRECTION + 2] = dx, dy, dz
        real[_ORIGIN], real[_ORIGIN + 1], real[_ORIGIN + 2] = origin[row, 0], origin[row, 1], origin[row, 2]
        whole[_SOURCE], whole[_TARGET], whole[_GOAL] = source[row], target[row], goal
        while True:
            now = whole[_GOAL]
            _, begin, unit = _aim(model, now == _ANY, ray, 1, row, origin, direction, source, tmax)
            real[_BEST], real[_UNIT], real[_BEGIN] = tmax[row], unit, begin
            whole[_FOUND], whole[_BESIDE] = -1, 0
            if _passes(ray, 1):
                call(model.blocked if now == _ANY else model.nearest, (np.uintp(model.scene), ray, at))
            if now == _ALL or whole[_BESIDE] == 0 or (now == _ANY and whole[_FOUND] >= 0):
                break
            whole[_GOAL] = _ALL
        patch_of[row] = whole[_FOUND]


@compiled
def _locate(model, rows, origin, direction, source, target, tmax, patch_of, hits):
    """Compute t, u and v of hits on the patches found, and whether float32 is sure of them."""
    surfaces, fields = pointer(np.uintp(model.patches), np.int32), pointer(np.uintp(model.patches), np.float32)
    vertices = pointer(np.uintp(model.vertices), np.float64)
    for lane in range(len(rows)):
        row = rows[lane]
        # What is computed for no patch is not used.
        patch = max(patch_of[row], 0)
        kz = dominant_axis(direction[row, 0], direction[row, 1], direction[row, 2])
        kx, ky = (kz + 1) % 3, (kz + 2) % 3
        hits[0, lane], hits[1, lane], hits[2, lane] = origin[row, kx], origin[row, ky], origin[row, kz]
        hits[3, lane], hits[4, lane], hits[5, lane] = direction[row, kx], direction[row, ky], direction[row, kz]
        for corner in range(4):
            place = _CORNERS + 3 * corner
            first = 12 * patch + 3 * corner
            hits[place, lane], hits[place + 1, lane], hits[place + 2, lane] = (
                vertices[first + kx], vertices[first + ky], vertices[first + kz])
        own = surfaces[4 * patch] == source[row] or surfaces[4 * patch] == target[row]
        hits[_TRIANGLE, lane], hits[_MOST, lane] = fields[4 * patch + 1], tmax[row]
        hits[_BORDER, lane] = 1.0 if own else fields[4 * patch + 2]
    # At fixed distances from one address, so that several lanes are computed at once.
    at, size, least = pointer(np.uintp(hits.ctypes.data), np.float64), _BATCH, model.slack * model.size
    for lane in range(len(rows)):
        ox, oy, oz, dz = at[lane], at[size + lane], at[2 * size + lane], at[5 * size + lane]
        sx, sy = at[3 * size + lane] / dz, at[4 * size + lane] / dz
        x0, y0, z0 = sheared(at[6 * size + lane], at[7 * size + lane], at[8 * size + lane], ox, oy, oz, sx, sy)
        x1, y1, z1 = sheared(at[9 * size + lane], at[10 * size + lane], at[11 * size + lane], ox, oy, oz, sx, sy)
        x2, y2, z2 = sheared(at[12 * size + lane], at[13 * size + lane], at[14 * size + lane], ox, oy, oz, sx, sy)
        x3, y3, z3 = sheared(at[15 * size + lane], at[16 * size + lane], at[17 * size + lane], ox, oy, oz, sx, sy)
        met, depth = inside(x0, y0, z0, x1, y1, z1, x2, y2, z2, x3, y3, z3)
        triangle, t = at[_TRIANGLE * size + lane] != 0, depth * (1 / dz)
        u, v = coordinates(x0, y0, x1, y1, x2, y2, x3, y3, triangle)
        across, beyond = u * (1 - v) if triangle else u, (1 - u) * (1 - v) if triangle else min(1 - u, 1 - v)
        sure = (met & (min(across, beyond, v) > at[_BORDER * size + lane]) & (t < at[_MOST * size + lane])
                & (t * abs(dz) > least))
        at[_T * size + lane], at[_U * size + lane], at[_V * size + lane] = t, u, v
        at[_SURE * size + lane] = 1.0 if sure else 0.0


@compiled
def _write(model, judged, any_hit, rows, hits, origin, direction, patch_of, t_of, u_of, v_of):
    """Write where rays hit the patches found; the number of hits that must be judged, whose rows are moved to front."""
    unsure, located, turned = 0, len(t_of) > 0, model.behind != 0 and not any_hit
    for lane in range(len(rows)):
        row = rows[lane]
        patch = patch_of[row]
        if patch == _UNSURE or (patch >= 0 and not judged and hits[_SURE, lane] == 0):
            rows[unsure] = row
            unsure += 1
            continue
        if located:
            met = patch >= 0
            t_of[row], u_of[row], v_of[row] = (
                hits[_T, lane] if met else np.inf, hits[_U, lane] if met else 0.0, hits[_V, lane] if met else 0.0)
        if turned and patch >= 0:
            _face(model, row, origin, direction, patch_of, u_of, v_of)
    return unsure


@compiled
def _face(model, row, origin, direction, patch_of, u_of, v_of):
    """Of two patches back to back have a ray hit the one that faces it."""
    patch = np.intp(patch_of[row])
    behind = np.intp(pointer(np.uintp(model.behind), np.int32)[patch])
    normal = pointer(np.uintp(model.normals + 24 * patch), np.float64)
    dx, dy, dz = direction[row, 0], direction[row, 1], direction[row, 2]
    if behind == patch or normal[0] * dx + normal[1] * dy + normal[2] * dz <= 0:
        return
    patch_of[row] = behind
    if len(u_of) > 0:
        vertices = array(pointer(np.uintp(model.vertices), np.float64), (model.count, 4, 3))
        kz = dominant_axis(dx, dy, dz)
        kx, ky = (kz + 1) % 3, (kz + 2) % 3
        along = direction[row, kz]
        u_of[row], v_of[row] = position(
            vertices, behind, pointer(np.uintp(model.patches), np.float32)[4 * behind + 1] != 0, kx, ky, kz,
            origin[row, kx], origin[row, ky], origin[row, kz], direction[row, kx] / along, direction[row, ky] / along)
