"""The list of a shadow frustum's rays: a word of main memory for each of them."""

import numpy as np

from golden.engine.frustum.shadow_record import ShadowRecord

__all__ = ["END_BIT", "RAY_WORD", "X_BIT", "Y_BIT", "pack_rays"]

RAY_WORD = np.dtype("<u8")
# Of a word: the first bits of the slopes x and y, in steps from the border of the grid, and of the end.
X_BIT, Y_BIT, END_BIT = 0, 20, 40


def pack_rays(record: ShadowRecord, number: np.ndarray) -> np.ndarray:
    """The words of K rays by their numbers, in this order: K uint64, little-endian.

    The upper bits of x and of y are the ray's column and row, the others its offset.
    """
    row, column = np.divmod(number, record.columns)
    x, y = (record.directions(column, row)[:, :2] + (1 << record.numbers.direction_fraction)).T.astype(np.uint64)
    end = record.end[number].astype(np.uint64)
    return (x << np.uint64(X_BIT) | y << np.uint64(Y_BIT) | end << np.uint64(END_BIT)).astype(RAY_WORD)
