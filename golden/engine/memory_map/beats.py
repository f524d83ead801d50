"""Patch geometry in beats of 72 bits, one vertex per beat."""

import numpy as np

__all__ = ["BEATS", "COORDINATE_BITS", "pack_beats", "unpack_beats"]

# Of a patch: id and surface, then a vertex each.
BEATS = 5
COORDINATE_BITS = 24


def pack_beats(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """... x 3 coordinates below 2^24 as beats of 72 bits: their low 64 bits (uint64) and highest 8 (uint8)."""
    x, y, z = np.moveaxis(np.asarray(vertices, dtype=np.uint64), -1, 0)
    shift = np.uint64(COORDINATE_BITS)
    return x | y << shift | z << 2 * shift, (z >> np.uint64(64 - 2 * COORDINATE_BITS)).astype(np.uint8)


def unpack_beats(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The ... x 3 int64 coordinates in beats of 72 bits."""
    shift, mask = np.uint64(COORDINATE_BITS), np.uint64((1 << COORDINATE_BITS) - 1)
    z = low >> 2 * shift | high.astype(np.uint64) << np.uint64(64 - 2 * COORDINATE_BITS)
    return np.stack([low & mask, low >> shift & mask, z], axis=-1).astype(np.int64)
