"""Ray pages: the pages that rays refer to in the cells that they pass."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.cast.rays import Hits, Rays
from golden.scene.cells import Cells
from radiosity.machines.common.columns import columns
from radiosity.machines.koan.scene_pages import CELL_BYTES, LIST_BYTES, PATCH_BYTES, ScenePages

__all__ = ["PageString", "ray_pages"]

# As in `golden.cast.grid`.
STILL = 2.0**-60


class PageString(NamedTuple):
    """What groups of rays, such as those of a pixel, refer to.

    Of the references of a group to a page the first and the last are listed, if the cache has as many frames as the
    group has pages: it cannot drop the page between them, so its faults are those of all references. Otherwise all are.

    Parameters
    ----------
    first
        G + 1 int64: where each group's references begin, and their number.
    page
        int32: their pages.
    distinct, touches
        G int64: pages of each group, and all its references.
    """

    first: np.ndarray
    page: np.ndarray
    distinct: np.ndarray
    touches: np.ndarray


class _Paths(NamedTuple):
    """Rays, the distances at which they end, and where each group's begin."""

    origin: np.ndarray
    direction: np.ndarray
    ends: np.ndarray
    first: np.ndarray


class _Grid(NamedTuple):
    """Cells with their lists, and where both are in memory."""

    base: np.ndarray
    margin: float
    size: float
    shape: np.ndarray
    start: np.ndarray
    patch: np.ndarray
    region: np.ndarray
    page_bytes: int


# Of a page: the last group that refers to it, and this group's first and last reference.
_Seen = columns("_Seen", "GROUP FIRST LAST")


def ray_pages(cells: Cells, layout: ScenePages, rays: Rays, hits: Hits, group: np.ndarray, groups: int, *,
              frames: int) -> PageString:
    """The references of rays that a grid has cast.

    A ray refers to each cell that it passes, to each entry of its list, and to the patch of that entry, until the cell
    in which it ends.

    Parameters
    ----------
    cells, layout
        The cells by which the rays were cast, and where they are in memory.
    rays, hits
        R rays and what they hit.
    group
        R int: the group of each, ascending.
    groups
        G.
    frames
        Frames of the cache that are free for these pages.

    Source: Badouel 1991, section 4.3, for a grid that is traversed after Amanatides and Woo.
    """
    first_ray = np.searchsorted(group, np.arange(groups + 1))
    touches = hits.steps + 2 * hits.tests
    most = int(np.diff(np.append(0, touches.cumsum())[first_ray]).max(initial=0))
    paths = _Paths(rays.origin, rays.direction, np.where(hits.patch >= 0, hits.t, rays.tmax), first_ray)
    grid = _Grid(cells.base, cells.margin, cells.size, cells.shape.astype(np.int64), cells.start.astype(np.int64),
                 cells.patch.astype(np.int64), layout.first, layout.page_bytes)
    buffer, distinct = np.empty(most, dtype=np.int32), np.zeros(groups, dtype=np.int64)
    all_touches, counts = np.zeros_like(distinct), np.zeros_like(distinct)

    def walk(filled, page):
        seen = np.full((len(layout), len(_Seen)), -1)
        _walk(paths, grid, buffer, seen, filled, page, distinct, all_touches, frames)

    walk(counts, np.empty(0, dtype=np.int32))
    first = np.append(0, counts.cumsum())
    page = np.empty(first[-1], dtype=np.int32)
    walk(first[:-1].copy(), page)
    return PageString(first=first, page=page, distinct=distinct, touches=all_touches)


@compiled
def _add(buffer, seen, group, at, page):
    """Add a reference to a group's, if it is not to the page of the one before."""
    if at and buffer[at - 1] == page:
        return at
    buffer[at] = page
    if seen[page, _Seen.GROUP] != group:
        seen[page, _Seen.GROUP], seen[page, _Seen.FIRST] = group, at
    seen[page, _Seen.LAST] = at
    return at + 1


@compiled
def _walk(paths, grid, buffer, seen, filled, pages, distinct, touches, frames):
    """Count the references of each group, or write them from ``filled`` on."""
    origin, direction, ends, size, shape, start = (paths.origin, paths.direction, paths.ends, grid.size, grid.shape,
                                                   grid.start)
    index, step, plane, between = (np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64), np.empty(3), np.empty(3))
    p, cross, inverse = np.empty(3), np.empty(3), np.empty(3)
    for group in range(len(filled)):
        at = 0
        touches[group] = 0
        for ray in range(paths.first[group], paths.first[group + 1]):
            largest = max(abs(direction[ray, 0]), abs(direction[ray, 1]), abs(direction[ray, 2]))
            entry, leave = 0.0, np.inf
            for axis in range(3):
                d = direction[ray, axis]
                p[axis] = (origin[ray, axis] - grid.base[axis]) + grid.margin
                extent = shape[axis] * size
                inverse[axis] = 0.0
                if abs(d) > STILL * largest:
                    inverse[axis] = 1 / d
                    low, high = (0 - p[axis]) * inverse[axis], (extent - p[axis]) * inverse[axis]
                    entry, leave = max(entry, min(low, high)), min(leave, max(low, high))
                elif not 0 <= p[axis] <= extent:
                    entry = np.inf
            if not (entry <= leave and entry < ends[ray]):
                continue
            for axis in range(3):
                d = direction[ray, axis]
                index[axis] = min(max(int((p[axis] + d * entry) / size), 0), shape[axis] - 1)
                step[axis], cross[axis] = 0, np.inf
                if inverse[axis] != 0:
                    step[axis] = 1 if d > 0 else -1
                    plane[axis] = (index[axis] + (1 if d > 0 else 0)) * size
                    between[axis] = step[axis] * size
                    cross[axis] = (plane[axis] - p[axis]) * inverse[axis]
            while True:
                cell = (index[0] * shape[1] + index[1]) * shape[2] + index[2]
                at = _add(buffer, seen, group, at, grid.region[0] + cell * CELL_BYTES // grid.page_bytes)
                touches[group] += 1 + 2 * (start[cell + 1] - start[cell])
                for place in range(start[cell], start[cell + 1]):
                    at = _add(buffer, seen, group, at, grid.region[1] + place * LIST_BYTES // grid.page_bytes)
                    at = _add(buffer, seen, group, at,
                              grid.region[2] + grid.patch[place] * PATCH_BYTES // grid.page_bytes)
                leave = min(cross[0], cross[1], cross[2])
                if ends[ray] <= leave:
                    break
                is_inside = True
                for axis in range(3):
                    if cross[axis] <= leave:
                        index[axis] += step[axis]
                        is_inside = is_inside and 0 <= index[axis] < shape[axis]
                        plane[axis] += between[axis]
                        cross[axis] = (plane[axis] - p[axis]) * inverse[axis]
                if not is_inside:
                    break
        distinct[group] = 0
        for place in range(at):
            distinct[group] += seen[buffer[place], _Seen.FIRST] == place
        found = 0
        for place in range(at):
            page = buffer[place]
            if distinct[group] > frames or seen[page, _Seen.FIRST] == place or seen[page, _Seen.LAST] == place:
                if len(pages):
                    pages[filled[group] + found] = page
                found += 1
        if not len(pages):
            filled[group] = found
