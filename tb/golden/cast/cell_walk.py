"""A ray's walk from cell to cell in plain Python, with the hits of brute force: what `Grid` must find, and count."""

import numpy as np

from golden.cast.grid import Grid
from golden.cast.rays import Hits, Rays

__all__ = ["cell_walk"]

# A component of a direction that much smaller than the largest one moves no ray.
STILL = 2.0**-60


def cell_walk(grid: Grid, rays: Rays, *, any_hit: bool = False) -> Hits:
    """The hits of rays in the cells of a grid; with ``any_hit`` a ray ends in the first cell that lists a hit patch."""
    sheared = grid.oracle.sheared(rays)
    best_t, best_patch = rays.tmax.copy(), np.full(len(rays), -1, dtype=np.int32)
    met = [{} for _ in range(len(rays))]
    for axis in range(3):
        some = np.flatnonzero(sheared.axis == axis)
        if len(some):
            for ray, patch, t in zip(*(part.tolist() for part in grid.oracle.all_hits(sheared, some)), strict=True):
                met[ray][patch] = t
    tests, steps = np.zeros((2, len(rays)), dtype=np.int64)
    positions = (rays.origin - grid.cells.base) + grid.cells.margin
    for ray in range(len(rays)):
        for patches, leave in _cells_of(grid.cells, positions[ray].tolist(), rays.direction[ray].tolist(),
                                        float(rays.tmax[ray])):
            steps[ray] += 1
            tests[ray] += len(patches)
            for patch in patches:
                t = met[ray].get(patch, np.inf)
                if t < best_t[ray] or (t == best_t[ray] and patch < best_patch[ray]):
                    best_t[ray], best_patch[ray] = t, patch
            if best_t[ray] <= leave or (any_hit and best_patch[ray] >= 0):
                break
    hit = np.flatnonzero(best_patch >= 0)
    u, v = np.zeros((2, len(rays)))
    u[hit], v[hit] = grid.oracle.uv(sheared, hit, best_patch[hit])
    return Hits(patch=best_patch, t=np.where(best_patch >= 0, best_t, np.inf), u=u, v=v, tests=tests, steps=steps)


def _cells_of(cells, position, direction, tmax):
    """The patches of each cell of a ray, and where it leaves the cell; through a corner into the opposite one."""
    shape, size = cells.shape.tolist(), cells.size
    axes = [axis for axis in range(3) if abs(direction[axis]) > STILL * max(map(abs, direction))]
    inverse = {axis: 1 / direction[axis] for axis in axes}
    ends = [sorted(((0 - position[axis]) * inverse[axis], (shape[axis] * size - position[axis]) * inverse[axis]))
            for axis in axes]
    entry, last = max(0.0, *(low for low, _ in ends)), min(high for _, high in ends)
    if not (entry <= last and entry < tmax) or any(
            not 0 <= position[axis] <= shape[axis] * size for axis in range(3) if axis not in axes):
        return
    index = [min(max(int((position[axis] + direction[axis] * entry) / size), 0), shape[axis] - 1) for axis in range(3)]
    border = {axis: (index[axis] + (direction[axis] > 0)) * size for axis in axes}
    while all(0 <= index[axis] < shape[axis] for axis in range(3)):
        number = (index[0] * shape[1] + index[1]) * shape[2] + index[2]
        crossing = {axis: (border[axis] - position[axis]) * inverse[axis] for axis in axes}
        leave = min(crossing.values())
        yield cells.patch[cells.start[number]:cells.start[number + 1]].tolist(), leave
        for axis in axes:
            if crossing[axis] <= leave:
                index[axis] += 1 if direction[axis] > 0 else -1
                border[axis] += size if direction[axis] > 0 else -size
