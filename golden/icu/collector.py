"""Collector: per-patch sums of the rays' form-factor weights."""

import numpy as np

__all__ = ["collect"]


def collect(patch: np.ndarray, weights: np.ndarray, patches: int) -> np.ndarray:
    """Sum of the weights of the rays that hit each patch.

    Sums of several clusters are merged by addition.

    Parameters
    ----------
    patch
        R, the patch of each ray or -1.
    weights
        R int64, see `Hemisphere.weights`.
    patches
        N.

    Returns
    -------
    N int64.
    """
    hit = patch >= 0
    sums = np.zeros(patches, dtype=np.int64)
    np.add.at(sums, patch[hit], weights[hit])
    return sums
