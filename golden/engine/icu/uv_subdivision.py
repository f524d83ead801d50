"""(u, v) by bounding-plane subdivision: a patch is bisected around the ray, with adders only."""

import numpy as np

from golden.engine.config import Icu
from golden.engine.icu.edge_planes import EDGES
from golden.engine.lib.fixed import bit_length, shift, signed

__all__ = ["align", "uv_subdivision"]


def align(distances: np.ndarray, exponents: np.ndarray, icu: Icu) -> np.ndarray:
    """The six distances of each hit brought to one exponent.

    Each V' has an exponent of its own, and n_ij the sum of two. The largest distance gets 2 ``uv_bits`` +
    ``uv_guard`` bits; the others are rounded to its unit.

    Parameters
    ----------
    distances
        K x 6 int64, see `edge_distances`.
    exponents
        K x 4 int64, exponents of the vertex directions.
    """
    scale = np.stack([exponents[:, i] + exponents[:, j] for i, j in EDGES], axis=1)
    top = np.where(distances != 0, bit_length(np.abs(distances)) + scale, -(1 << 10)).max(axis=1)
    by = scale - top[:, None] + 2 * icu.uv_bits + icu.uv_guard
    return shift(distances, np.clip(np.where(distances != 0, by, 0), -62, None))


def uv_subdivision(distances: np.ndarray, orientation: np.ndarray, icu: Icu) -> tuple[np.ndarray, np.ndarray]:
    """The step of each patch's lattice that its ray hits, from alternate bits of u and v (docs/exactness.md).

    Parameters
    ----------
    distances
        K x 6 int64, aligned.
    orientation
        K int64, the orientations for which the rays are inside.

    Returns
    -------
    K int64 u and v, 0 to 2^``uv_bits`` - 1. At a repeated vertex one of them is undefined.

    Source: Shen 1993, section 5.3.5.
    """
    number = signed(2 * icu.uv_bits + icu.uv_guard + 1, 0)
    d01, d12, d23, d30, d02, d13 = number.check(distances * orientation[:, None], "aligned edge distance").T
    u, v = np.zeros((2, len(distances)), dtype=np.int64)
    for _ in range(icu.uv_bits):
        cut = number.check((d13 - d30 + d02 + d12) >> 2, "distance of the cut in u")
        left = cut >= 0
        d02, d13, d01, d12, d23, d30 = (
            np.where(left, d02 - d30, d02 + d12) >> 1, np.where(left, d13 - d30, d13 + d12) >> 1,
            d01 >> 1, np.where(left, cut, d12), d23 >> 1, np.where(left, d30, -cut))
        u = 2 * u + ~left
        cut = number.check((d01 + d02 - d13 - d23) >> 2, "distance of the cut in v")
        lower = cut <= 0
        d02, d13, d01, d12, d23, d30 = (
            np.where(lower, d02 + d01, d02 - d23) >> 1, np.where(lower, d13 - d01, d13 + d23) >> 1,
            np.where(lower, d01, cut), d12 >> 1, np.where(lower, -cut, d23), d30 >> 1)
        v = 2 * v + ~lower
    return icu.uv.check(u, "u"), icu.uv.check(v, "v")
