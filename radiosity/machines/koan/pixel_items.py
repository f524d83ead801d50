"""Pixel items: the picture in one tile for each node, and tiles in small squares that nodes request from each other."""

from typing import NamedTuple

import numpy as np

from golden.base.errors import InputError, check_choice, check_int

__all__ = ["MOST_PIXELS", "SCHEDULES", "PixelItems", "pixel_items", "tile_shape"]

SCHEDULES = ("mixed", "static", "scattered")
"""``mixed``: tiles whose items are shared; ``static``: tiles; ``scattered``: items dealt in turn, and shared."""

MOST_PIXELS = 1 << 13
"""Of a row or a column."""


class PixelItems(NamedTuple):
    """I items in the order in which nodes have them.

    Parameters
    ----------
    pixel
        Numbers of all pixels, item by item.
    first
        I + 1 int64: the first entry of each item in ``pixel``.
    own
        N + 1 int64: the first item of each node.
    """

    pixel: np.ndarray
    first: np.ndarray
    own: np.ndarray


def tile_shape(nodes: int, size: tuple[int, int]) -> tuple[int, int]:
    """Columns and rows of tiles, as square as they can be.

    Source: Badouel 1991, section 4.2.
    """
    width, height = size
    shapes = [(columns, nodes // columns) for columns in range(1, nodes + 1) if nodes % columns == 0]
    return min(shapes, key=lambda one: abs(np.log(width / one[0] * one[1] / height)))


def pixel_items(size: tuple[int, int], nodes: int, *, side: int = 3, schedule: str = "mixed") -> PixelItems:
    """Divide a picture.

    Parameters
    ----------
    size
        Width and height.
    nodes
        N.
    side
        Pixels along an item; items at the edge of a tile are smaller.
    schedule
        A name of `SCHEDULES`.

    Raises
    ------
    TypeError
        The side is no int.
    InputError
        The side is below 1, the schedule is none, the picture has more than `MOST_PIXELS` columns or rows, or fewer
        than tiles.

    Source: Badouel 1991, section 4.2.
    """
    check_int("koan: Item", side)
    if side < 1:
        raise InputError(f"koan: Item must be at least 1 pixel along its side, not {side!r}", parameter="item")
    check_choice("koan: Schedule", schedule, SCHEDULES)
    width, height = size
    for name, value in (("Width", width), ("Height", height)):
        if not 1 <= value <= MOST_PIXELS:
            raise InputError(f"koan: {name} must be 1 to {MOST_PIXELS}, not {value!r}", parameter=name)
    columns, rows = tile_shape(nodes, size)
    if columns > width or rows > height:
        raise InputError(f"koan: Size must be at least {columns}x{rows} for {nodes} nodes, not {width}x{height}",
                         parameter="size")
    grid = np.arange(width * height).reshape(height, width)
    tiles = [[] for _ in range(nodes)]
    for row, band in enumerate(np.array_split(grid, rows)):
        for column, tile in enumerate(np.array_split(band, columns, axis=1)):
            tiles[row * columns + column] = [
                tile[top:top + side, left:left + side].ravel()
                for top in range(0, tile.shape[0], side) for left in range(0, tile.shape[1], side)]
    if schedule == "scattered":
        every = [item for tile in tiles for item in tile]
        tiles = [every[node::nodes] for node in range(nodes)]
    items = [item for tile in tiles for item in tile]
    return PixelItems(np.concatenate(items), np.cumsum([0, *map(len, items)]), np.cumsum([0, *map(len, tiles)]))
