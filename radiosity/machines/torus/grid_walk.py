"""Grid walk: a ray in the grid of a node, voxel by voxel, until it hits, leaves or reaches its light."""

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.torus.columns import Grid, Reference, Walk
from radiosity.machines.torus.node_grids import NodeGrids
from radiosity.machines.torus.object_tests import hit_distance
from radiosity.machines.torus.torus_scene import Objects

__all__ = ["BLOCKED", "EXIT", "HIT", "REACHED", "walk"]

HIT, EXIT, REACHED, BLOCKED = range(4)
"""How a walk ends."""

_NONE = -1


@compiled
def walk(grids: NodeGrids, objects: Objects, node: int, origin: np.ndarray, direction: np.ndarray, entry: float,
         limit: float, mail: np.ndarray, number: int, counts: np.ndarray) -> tuple[int, int, float]:
    """Walk from the voxel at the distance ``entry`` on.

    The nearest hit counts when the ray is in its voxel; of equal ones, that of the object with the least number. A
    ray with a limit, a shadow ray, ends at the first hit before it.

    Parameters
    ----------
    grids, objects, node
        Voxels, objects, and whose grid.
    origin, direction
        The ray.
    entry
        Distance at which it enters the grid; 0 if it starts there.
    limit
        Distance of its light; infinite of other rays.
    mail
        N int64: the last ray that was tested with each object.
    number
        This ray's, which no walk had before. Nodes do not share mailboxes: all walks have numbers of their own, so one
        array stands for those of all nodes.
    counts
        int64 by `Walk`, added to.

    Returns
    -------
    How the walk ends; the object of a hit, or the face of an exit (0 to 5: +x, -x, +y, -y, +z, -z); the distance.

    Source: Pearce 1987, chapters 2 and 4.
    """
    subdivisions, table, entries, bits = (grids.shape[node, Grid.SUBDIVISIONS], grids.shape[node, Grid.TABLE],
                                          grids.shape[node, Grid.ENTRIES], grids.shape[node, Grid.BITS])
    side, mask = subdivisions + 2, grids.shape[node, Grid.ENTRIES] - 1
    step, hop = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    delta, dist = np.full(3, np.inf), np.full(3, np.inf)
    index, stride = 0, side * side
    for axis in range(3):
        low, size = grids.low[node, axis], grids.cell[node, axis]
        place = np.floor((origin[axis] + entry * direction[axis] - low) / size)
        place = min(max(place, 0.0), subdivisions - 1.0)
        index += (int(place) + 1) * stride
        if direction[axis] > 0:
            step[axis], delta[axis] = stride, size / direction[axis]
            dist[axis] = (low + (place + 1) * size - origin[axis]) / direction[axis]
        elif direction[axis] < 0:
            step[axis], delta[axis] = -stride, -size / direction[axis]
            dist[axis] = (low + place * size - origin[axis]) / direction[axis]
        if entries:
            hop[axis] = step[axis] & mask if step[axis] >= 0 else entries - (-step[axis] & mask)
        stride //= side
    slot = index & mask
    small = _smallest(dist)
    best, nearest = _NONE, np.inf
    while True:
        if entries:
            is_full = (grids.bits[bits + (index >> 3)] >> (index & 7) & 1) != 0
            at = grids.table[table + slot] if is_full else _NONE
        else:
            at = grids.table[table + index]
            if at < _NONE:
                return EXIT, -2 - at, _crossed(dist, delta, (-2 - at) // 2)
            is_full = at != _NONE
        is_tagged = not entries
        while at != _NONE:
            counts[Walk.CHAINED] += 1
            reference = grids.references[at]
            at = reference[Reference.NEXT]
            if entries:
                if reference[Reference.TAG] != index:
                    continue
                is_tagged = True
            one = reference[Reference.OBJECT]
            if mail[one] == number:
                continue
            mail[one] = number
            is_polygon = objects.counts[one] > 0
            counts[Walk.POLYGON_TESTS if is_polygon else Walk.SPHERE_TESTS] += 1
            distance = hit_distance(objects, one, origin, direction)
            if distance < np.inf:
                counts[Walk.POLYGON_HITS if is_polygon else Walk.SPHERE_HITS] += 1
                if distance < limit < np.inf:
                    return BLOCKED, one, distance
                if distance < nearest or (distance == nearest and one < best):
                    best, nearest = one, distance
        if is_full and not is_tagged:
            # A bit without an entry is a shell voxel.
            axis = _latest(dist, delta)
            return EXIT, 2 * axis + (direction[axis] < 0), _crossed(dist, delta, axis)
        if best != _NONE and nearest <= dist[small] and limit == np.inf:
            return HIT, best, nearest
        if limit <= dist[small]:
            return REACHED, _NONE, limit
        slot = (slot + hop[small]) & mask
        index += step[small]
        dist[small] += delta[small]
        small = _smallest(dist)
        counts[Walk.STEPS] += 1


@compiled
def _smallest(dist):
    """The axis of the next wall: y before x at equal distances, and both before z."""
    small = 0 if dist[0] < dist[1] else 1
    return 2 if dist[2] < dist[small] else small


@compiled
def _latest(dist, delta):
    """The axis that was crossed last: that of the latest wall."""
    axis = 0
    for other in range(1, 3):
        if _crossed(dist, delta, other) > _crossed(dist, delta, axis):
            axis = other
    return axis


@compiled
def _crossed(dist, delta, axis):
    """Distance of the wall of an axis that was crossed last; of an axis that is never crossed, none."""
    return dist[axis] - delta[axis] if delta[axis] < np.inf else -np.inf
