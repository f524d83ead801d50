"""A frustum cut into sections that each fit the ray memory of a cluster."""

from dataclasses import replace

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.schedule.sections import cut_sections, grid_of

__all__ = ["halves", "most_sections", "tile_sections", "window_sections"]


def most_sections(columns: int, rows: int, config: Config) -> int:
    """The largest power of two of sections that a frustum can be cut into: each has a tile of the settle map."""
    side, count = 1 << config.icu.tile_bits, 1
    across, down = -(-columns // side), -(-rows // side)
    while grid_of(2 * count)[0] <= across and grid_of(2 * count)[1] <= down:
        count *= 2
    return count


def tile_sections(columns: int, rows: int, config: Config, *, clusters: int = 1,
                  workload: np.ndarray | None = None) -> tuple[Sector, ...]:
    """As few sections as fit, at least ``clusters``, of about equal work; their number is a power of two.

    Cuts are at borders of tiles of the settle map: a section takes whole tiles of the ray memory.

    Parameters
    ----------
    columns, rows
        Rays of the frustum.
    config
        The machine's configuration.
    clusters
        A power of two.
    workload
        rows x columns float64, the expected work of each ray. Default: the same for all.

    Raises
    ------
    InputError
        As `cut_sections`, of tiles instead of rays: there are too few rows or columns of them.
    """
    side = 1 << config.icu.tile_bits
    rays = np.zeros((-(-rows // side) * side, -(-columns // side) * side))
    rays[:rows, :columns] = 1 if workload is None else workload
    tiles = rays.reshape(len(rays) // side, side, -1, side).sum(axis=(1, 3))
    capacity, count = config.icu.rays >> 2 * config.icu.tile_bits, clusters
    while _largest(tiles.shape, count) > capacity:
        count *= 2
    partition = cut_sections(tiles, clusters=count, ray_capacity=capacity)
    return tuple(Sector(section.first_column * side, min(columns, section.end_column * side),
                        section.first_row * side, min(rows, section.end_row * side))
                 for section in partition.sections)


def window_sections(column: np.ndarray, row: np.ndarray, *, columns: int, rows: int,
                    config: Config) -> tuple[Sector, ...]:
    """Sections of whole tiles with these K rays, and with few others.

    Tiles beside each other are a section, and so are such ones of the same columns above each other, while they fit.

    Parameters
    ----------
    column, row
        K int each: the rays.
    columns, rows
        Rays of the frustum.
    config
        The machine's configuration.
    """
    bits, capacity = config.icu.tile_bits, config.icu.rays >> 2 * config.icu.tile_bits
    tiles = np.unique(np.stack([row >> bits, column >> bits], axis=1), axis=0)
    # First and end column, first and end row.
    runs: list[list[int]] = []
    for down, across in tiles.tolist():
        if runs and runs[-1][1:3] == [across, down] and across - runs[-1][0] < capacity:
            runs[-1][1] += 1
        else:
            runs.append([across, across + 1, down, down + 1])
    found, above = [], {}
    for run in runs:
        first, end, down, _ = run
        top = above.get((first, end))
        if top and top[3] == down and (end - first) * (down + 1 - top[2]) <= capacity:
            top[3] += 1
        else:
            above[first, end] = run
            found.append(run)
    return tuple(Sector(first << bits, min(columns, end << bits), top << bits, min(rows, bottom << bits))
                 for first, end, top, bottom in found)


def halves(section: Sector, config: Config) -> tuple[Sector, ...]:
    """A section cut in two between columns of tiles of the settle map, as near to its middle as possible.

    One of a single column of tiles stays whole. The section begins at a border of tiles.
    """
    side = 1 << config.icu.tile_bits
    across = -(-(section.end_column - section.first_column) // side)
    middle = section.first_column + across // 2 * side
    return (section,) if across < 2 else (replace(section, end_column=middle), replace(section, first_column=middle))


def _largest(shape, count):
    """Tiles of the largest of ``count`` sections."""
    rows, columns = shape
    across, down = grid_of(count)
    return -(-columns // across) * -(-rows // down)
