"""Mesh load: boxes tallied to the cells of a mesh on the screen, and what is split by these."""

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import InputError
from radiosity.machines.merge.box_cuts import can_be_cut
from radiosity.machines.merge.work_weights import WorkWeights

__all__ = ["check_mesh", "edge_loads", "halve_mesh", "hilbert_index", "hilbert_shares", "mesh_loads"]


def check_mesh(mesh: int, width: int, height: int) -> None:
    """A mesh has cells of whole pixels, as many as a power of two along each side.

    Raises
    ------
    InputError
        It does not.
    """
    if mesh < 1 or mesh & (mesh - 1) or width % mesh or height % mesh:
        raise InputError(f"volume: Mesh must be a power of two that divides {width} x {height} pixels, not {mesh!r}",
                         parameter="mesh")


def mesh_loads(boxes: np.ndarray, weights: WorkWeights, mesh: int, width: int, height: int) -> np.ndarray:
    """Mesh x mesh float64, rows first: each box adds its weight, divided by the cells that it meets, to each of these.

    So do its spans, each in a row of cells, and its pixels, each in a cell.

    Source: Kurc 1997, sections 6.1.4 and 6.4.
    """
    loads = np.zeros((mesh, mesh))
    _tally(boxes, np.array([weights.triangle, weights.span, weights.pixel], dtype=np.float64), width // mesh,
           height // mesh, loads)
    return loads


@compiled
def _tally(boxes, weights, wide, high, loads):
    for box in range(len(boxes)):
        first_x, first_y, last_x, last_y = boxes[box]
        columns = last_x // wide - first_x // wide + 1
        rows = last_y // high - first_y // high + 1
        for row in range(first_y // high, last_y // high + 1):
            tall = min(last_y, row * high + high - 1) - max(first_y, row * high) + 1
            for column in range(first_x // wide, last_x // wide + 1):
                across = min(last_x, column * wide + wide - 1) - max(first_x, column * wide) + 1
                loads[row, column] += (weights[0] / (columns * rows) + weights[1] * tall / columns
                                       + weights[2] * tall * across)


def edge_loads(boxes: np.ndarray, weights: WorkWeights, mesh: int, width: int, height: int) -> np.ndarray:
    """2 x mesh x mesh float64: what crosses the edge between each cell and the one on its right, and the one below it.

    A box in one row or one column of cells counts whole on each edge that it crosses, others divided by the cells that
    they meet. Spans lie in a row; pixels cross nothing.

    Source: Kurc 1997, section 6.1.6.
    """
    edges = np.zeros((2, mesh, mesh))
    _tally_edges(boxes, float(weights.triangle), float(weights.span), width // mesh, height // mesh, edges)
    return edges


@compiled
def _tally_edges(boxes, triangle, span, wide, high, edges):
    for box in range(len(boxes)):
        left, top, right, bottom = boxes[box, 0] // wide, boxes[box, 1] // high, boxes[box, 2] // wide, boxes[
            box, 3] // high
        cells = (right - left + 1) * (bottom - top + 1)
        weight = triangle if left == right or top == bottom else triangle / cells
        for row in range(top, bottom + 1):
            tall = min(boxes[box, 3], row * high + high - 1) - max(boxes[box, 1], row * high) + 1
            for column in range(left, right + 1):
                if column < right:
                    edges[0, row, column] += weight + span * tall
                if row < bottom:
                    edges[1, row, column] += weight


def halve_mesh(loads: np.ndarray, levels: int) -> list[np.ndarray]:
    """The owners of the cells after each level: mesh x mesh int64.

    A table of sums of all cells above and on the left gives the load of any rectangle. The longer side of a region is
    cut, of equal ones the height, where both halves are most equal.

    Source: Kurc 1997, section 6.1.4.

    Raises
    ------
    InputError
        The mesh has not enough cells.
    """
    mesh = len(loads)
    if not can_be_cut(mesh, mesh, [(0, 1)] * levels):
        raise InputError(f"volume: Nodes must be at most the {mesh * mesh} cells of the mesh, not {1 << levels}",
                         parameter="nodes")
    table = np.zeros((mesh + 1, mesh + 1))
    table[1:, 1:] = loads.cumsum(axis=1).cumsum(axis=0)
    regions, found = [(0, mesh, 0, mesh)], [np.zeros((mesh, mesh), dtype=np.int64)]
    for level in range(levels):
        later = [(0, 1)] * (levels - level - 1)
        regions = [half for region in regions for half in _halves(table, region, later)]
        owner = np.empty((mesh, mesh), dtype=np.int64)
        for node, (top, bottom, left, right) in enumerate(regions):
            owner[top:bottom, left:right] = node
        found.append(owner)
    return found


def _halves(table, region, later):
    top, bottom, left, right = region
    is_wide = right - left > bottom - top
    low, high, other = (left, right, bottom - top) if is_wide else (top, bottom, right - left)
    at = np.arange(low + 1, high)
    sums = (table[bottom, at] - table[top, at] - table[bottom, left] + table[top, left] if is_wide
            else table[at, right] - table[at, left] - table[top, right] + table[top, left])
    whole = table[bottom, right] - table[top, right] - table[bottom, left] + table[top, left]
    is_possible = can_be_cut(at - low, other, later) & can_be_cut(high - at, other, later)
    cut = at[np.argmin(np.where(is_possible, np.abs(2 * sums - whole), np.inf))]
    return [(top, bottom, left, cut), (top, bottom, cut, right)] if is_wide else [
        (top, cut, left, right), (cut, bottom, left, right)]


def hilbert_index(mesh: int) -> np.ndarray:
    """Mesh x mesh int64: the position of each cell along a Hilbert curve, whose steps are neighbours."""
    y, x = np.divmod(np.arange(mesh * mesh), mesh)
    index, side = np.zeros(mesh * mesh, dtype=np.int64), mesh // 2
    while side:
        on_right, below = (x & side) > 0, (y & side) > 0
        index += side * side * ((3 * on_right) ^ below)
        is_flipped = ~below & on_right
        x, y = np.where(is_flipped, mesh - 1 - x, x), np.where(is_flipped, mesh - 1 - y, y)
        x, y = np.where(below, x, y), np.where(below, y, x)
        side //= 2
    return index.reshape(mesh, mesh)


def hilbert_shares(loads: np.ndarray, nodes: int) -> np.ndarray:
    """Mesh x mesh int64: the owners of the cells, whose curve is cut at multiples of an equal share.

    A cell goes to the share that has its middle.

    Source: Kurc 1997, section 6.1.5.
    """
    index = hilbert_index(len(loads)).ravel()
    along = np.empty(len(index))
    along[index] = loads.ravel()
    before = np.cumsum(along) - along / 2
    total = along.sum()
    share = np.minimum((before * nodes / total).astype(np.int64) if total else np.zeros(len(along), np.int64),
                       nodes - 1)
    return share[index].reshape(loads.shape)
