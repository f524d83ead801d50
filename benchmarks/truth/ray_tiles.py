"""Tiles of neighbouring rays, and the tiles that a cone of planes may meet."""

import numpy as np

__all__ = ["RayTiles"]


class RayTiles:
    """Rays in tiles of `SIDE` x `SIDE`, each with the box of its directions.

    A tile is left out only where one plane is negative on all of its box. The greatest n . d of a box is the sum of
    the greatest of each product: exact, since components of n are below 2^36 and those of d at most 2^16.

    Parameters
    ----------
    directions
        Rows x columns x 3 integers.
    """

    SIDE = 16

    def __init__(self, directions):
        directions = np.asarray(directions, np.int64)
        rows, columns = directions.shape[:2]
        row, column = np.divmod(np.arange(rows * columns), columns)
        tile = row // self.SIDE * -(-columns // self.SIDE) + column // self.SIDE
        self._order = np.argsort(tile, kind="stable")
        self.rays = directions.reshape(-1, 3)[self._order]
        self._starts = np.flatnonzero(np.diff(tile[self._order], prepend=-1))
        self._sizes = np.diff(self._starts, append=len(tile))
        self._ends = [[bound.reduceat(self.rays[:, axis], self._starts) for bound in (np.minimum, np.maximum)]
                      for axis in range(3)]

    def met(self, cones, *, slack: int = 0) -> np.ndarray:
        """Rows of `rays`: all of a tile that may hold one with n . d >= -slack for all planes n of one of the cones."""
        may = np.zeros(len(self._starts), bool)
        for planes in cones:
            inside = np.ones(len(self._starts), bool)
            for plane in planes:
                inside &= sum(n * ends[n > 0] for n, ends in zip(plane, self._ends, strict=True)) >= -slack
            may |= inside
        sizes = self._sizes[may]
        return np.repeat(self._starts[may] - np.cumsum(sizes) + sizes, sizes) + np.arange(sizes.sum())

    def numbers(self, rows: np.ndarray) -> np.ndarray:
        """The numbers row x columns + column of some of `rays`."""
        return self._order[rows]
