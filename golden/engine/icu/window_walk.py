"""Window walk: the scan of a window tile by tile, in the layout of the settle map."""

import numpy as np

from golden.engine.config import Icu
from golden.engine.icu.section_clip import SectionWindow

__all__ = ["issue_cycles", "ray_address", "walk_cycles", "window_rays", "window_tiles"]


def ray_address(column: np.ndarray, row: np.ndarray, tiles_across: int, icu: Icu) -> np.ndarray:
    """Address of rays in the ray memory: number of the tile, row in it, column in it.

    Parameters
    ----------
    column, row
        int64, relative to the section's first.
    tiles_across
        Tiles in a row of tiles of the section.
    """
    side = icu.tile_bits
    low = (1 << side) - 1
    tile = (row >> side) * tiles_across + (column >> side)
    return (tile << 2 * side) | (row & low) << side | (column & low)


def window_tiles(window: SectionWindow, icu: Icu) -> np.ndarray:
    """P int64: words of the settle map that the scan of each window reads, a tile of both pieces twice; at least 1."""
    side = icu.tile_bits

    def tiles(first, count):
        return np.where(count > 0, (first + count - 1 >> side) - (first >> side) + 1, 0)

    across = tiles(window.column_first, window.column_count) + tiles(np.zeros_like(window.column_first),
                                                                     window.wrapped_count)
    return np.maximum(across * tiles(window.row_first, window.row_count), 1)


def window_rays(window: SectionWindow, which: int, icu: Icu) -> tuple[np.ndarray, np.ndarray]:
    """Columns and rows of a window's rays, relative to the section's first, in the order of the scan.

    Tile by tile, in each row of tiles the first piece before the wrapped one; in a tile row by row.
    """
    first, count, wrapped, top, rows = (int(value[which]) for value in vars(window).values())
    piece = np.repeat([0, 1], [count, wrapped])
    column = np.concatenate([first + np.arange(count), np.arange(wrapped)])
    row = top + np.arange(rows)
    piece, column, row = (np.broadcast_to(value, (rows, len(column))).ravel()
                          for value in (piece[None], column[None], row[:, None]))
    order = np.lexsort((column, row, column >> icu.tile_bits, piece, row >> icu.tile_bits))
    return column[order], row[order]


def walk_cycles(window: SectionWindow, live: np.ndarray, icu: Icu) -> np.ndarray:
    """P int64: cycles of the scan of each window if ``live`` (P) of its rays may improve."""
    return np.maximum(window_tiles(window, icu), live)


def issue_cycles(patch: np.ndarray, column: np.ndarray, row: np.ndarray, lanes: int, icu: Icu) -> np.ndarray:
    """Cycles in which the rays of tests are issued when up to ``lanes`` of a tile are in a cycle.

    Parameters
    ----------
    patch, column, row
        T int64: the patch of each test; column and row of its ray, relative to the section's first.
    lanes
        Rays that are tested in a cycle.

    Returns
    -------
    :
        P int64: of each patch up to the largest number.
    """
    tile = np.stack([patch, row >> icu.tile_bits, column >> icu.tile_bits])
    tiles, rays = np.unique(tile, axis=1, return_counts=True)
    return np.bincount(tiles[0], weights=-(-rays // lanes)).astype(np.int64)
