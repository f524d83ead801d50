"""The settle map of a section as words."""

import numpy as np

from golden.engine.config import Config

__all__ = ["settle_words"]


def settle_words(codes: np.ndarray, config: Config) -> list[list[int]]:
    """Settle codes of a section's rows and columns, tile by tile: values of `Formats.settle_word`.

    Rays beyond the section's border have the code 0: they are never written.
    """
    side = 1 << config.icu.tile_bits
    rows, columns = codes.shape
    whole = np.zeros((-(-rows // side) * side, -(-columns // side) * side), dtype=np.int64)
    whole[:rows, :columns] = codes
    return whole.reshape(len(whole) // side, side, -1, side).transpose(0, 2, 1, 3).reshape(-1, side * side).tolist()
