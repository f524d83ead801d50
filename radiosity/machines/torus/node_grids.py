"""Node grids: the voxels of each node, as an array or as a hash table with a bit for each voxel."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.torus.columns import Grid, Reference
from radiosity.machines.torus.node_boxes import NodeBoxes
from radiosity.machines.torus.object_tests import meets_box
from radiosity.machines.torus.torus_scene import Objects

__all__ = ["NodeGrids", "node_grids"]

_NONE = -1
# Voxels take in what touches them within so many of their sizes, so that rounding loses no object.
_SLACK = 1e-6


class NodeGrids(NamedTuple):
    """Voxels in flat arrays, which compiled functions read. A layer of shell voxels surrounds each grid.

    Parameters
    ----------
    shape
        P x 4 int64, see `Grid`.
    low, cell
        P x 3 float64: the corner of each node's grid, and the sizes of its voxels.
    table
        int64: of an array, each voxel's first reference, -1 if it is empty, and -2 less the face of a shell voxel;
        of a hash table, the first reference of each chain or -1.
    bits
        uint8: of a hash table, a bit for each voxel that is not empty, or of the shell.
    references
        R x 3 int64, see `Reference`.
    held
        P int64: objects that each node has.
    counts
        P x 3 int64: references, those that share an entry with others, and voxels that are not empty.
    """

    shape: np.ndarray
    low: np.ndarray
    cell: np.ndarray
    table: np.ndarray
    bits: np.ndarray
    references: np.ndarray
    held: np.ndarray
    counts: np.ndarray


def node_grids(objects: Objects, bounds: np.ndarray, boxes: NodeBoxes, *, subdivisions: int,
               entries: int = 0) -> NodeGrids:
    """Assign each node's objects to its voxels.

    An object is in each voxel that its surface meets. References are prepended. In an array, an object's voxels that
    were empty share its first reference.

    Parameters
    ----------
    objects, bounds
        The objects, and N x 2 x 3 float64: their bounds.
    boxes
        The nodes' boxes.
    subdivisions
        v: voxels along each axis of a grid.
    entries
        M: heads of a hash table, a power of two; 0 for an array.

    Source: Pearce 1987, chapters 2 and 4.
    """
    nodes, side = len(boxes.grown), subdivisions + 2
    voxels, heads = side ** 3, entries or side ** 3
    shape = np.zeros((nodes, len(Grid)), dtype=np.int64)
    shape[:, Grid.SUBDIVISIONS], shape[:, Grid.ENTRIES] = subdivisions, entries
    shape[:, Grid.TABLE] = np.arange(nodes) * heads
    bytes_of_bits = (voxels + 7) // 8 if entries else 0
    shape[:, Grid.BITS] = np.arange(nodes) * bytes_of_bits
    grids = NodeGrids(shape=shape, low=boxes.grown[:, 0].copy(),
                      cell=(boxes.grown[:, 1] - boxes.grown[:, 0]) / subdivisions,
                      table=np.full(nodes * heads, _NONE, dtype=np.int64),
                      bits=np.zeros(nodes * bytes_of_bits, dtype=np.uint8),
                      references=np.zeros((0, 3), dtype=np.int64), held=np.zeros(nodes, dtype=np.int64),
                      counts=np.zeros((nodes, 3), dtype=np.int64))
    capacity = 4 * len(bounds) + 4096
    while True:
        references = np.full((capacity, 3), _NONE, dtype=np.int64)
        used = _assign(grids, references, objects, bounds)
        if used <= capacity:
            return grids._replace(references=references[:max(used, 1)].copy())
        capacity = 2 * capacity
        for array, value in ((grids.table, _NONE), (grids.bits, 0), (grids.held, 0), (grids.counts, 0)):
            array[...] = value


@compiled
def _assign(grids, references, objects, bounds):
    """References of all nodes; more than the capacity if they do not fit."""
    used = 0
    low, high = np.zeros(3), np.zeros(3)
    first, last = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    for node in range(len(grids.shape)):
        subdivisions, table, entries = (grids.shape[node, Grid.SUBDIVISIONS], grids.shape[node, Grid.TABLE],
                                        grids.shape[node, Grid.ENTRIES])
        side = subdivisions + 2
        _surround(grids, node)
        for number in range(len(bounds)):
            is_outside = False
            for axis in range(3):
                size = grids.cell[node, axis]
                start = (bounds[number, 0, axis] - grids.low[node, axis]) / size
                end = (bounds[number, 1, axis] - grids.low[node, axis]) / size
                is_outside |= start > subdivisions + _SLACK or end < -_SLACK
                first[axis] = max(0, int(np.floor(min(max(start - _SLACK, 0.0), float(subdivisions)))))
                last[axis] = min(subdivisions - 1, int(np.floor(min(max(end + _SLACK, 0.0), float(subdivisions)))))
                first[axis] = min(first[axis], last[axis])
            if is_outside:
                continue
            shared = _NONE
            is_held = False
            for x in range(first[0], last[0] + 1):
                for y in range(first[1], last[1] + 1):
                    for z in range(first[2], last[2] + 1):
                        for axis in range(3):
                            place = x if axis == 0 else y if axis == 1 else z
                            size = grids.cell[node, axis]
                            low[axis] = grids.low[node, axis] + (place - _SLACK) * size
                            high[axis] = grids.low[node, axis] + (place + 1 + _SLACK) * size
                        if not meets_box(objects, number, low, high):
                            continue
                        is_held = True
                        index = ((x + 1) * side + y + 1) * side + z + 1
                        head = table + (index & (entries - 1) if entries else index)
                        grids.counts[node, 0] += 1
                        if entries:
                            at = grids.shape[node, Grid.BITS] + (index >> 3)
                            if not grids.bits[at] >> (index & 7) & 1:
                                grids.counts[node, 2] += 1
                                grids.bits[at] |= np.uint8(1 << (index & 7))
                        elif grids.table[head] == _NONE:
                            grids.counts[node, 2] += 1
                            if shared != _NONE:
                                grids.counts[node, 1] += 1
                                grids.table[head] = shared
                                continue
                        if used < len(references):
                            references[used, Reference.OBJECT], references[used, Reference.TAG] = number, index
                            references[used, Reference.NEXT] = grids.table[head]
                            if not entries and grids.table[head] == _NONE:
                                shared = used
                            grids.table[head] = used
                        used += 1
            grids.held[node] += is_held
    return used


@compiled
def _surround(grids, node):
    """Mark the shell: of an array by its face, of a hash table by the bit alone."""
    side = grids.shape[node, Grid.SUBDIVISIONS] + 2
    table, entries = grids.shape[node, Grid.TABLE], grids.shape[node, Grid.ENTRIES]
    index = 0
    for x in range(side):
        for y in range(side):
            for z in range(side):
                face = _NONE
                if x == side - 1 or x == 0:
                    face = 0 if x else 1
                elif y == side - 1 or y == 0:
                    face = 2 if y else 3
                elif z == side - 1 or z == 0:
                    face = 4 if z else 5
                if face != _NONE:
                    if entries:
                        grids.bits[grids.shape[node, Grid.BITS] + (index >> 3)] |= np.uint8(1 << (index & 7))
                    else:
                        grids.table[table + index] = -2 - face
                index += 1
