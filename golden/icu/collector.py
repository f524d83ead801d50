"""Collector: per-patch sums of the rays' form-factor weights."""

import numpy as np

__all__ = ["collect"]


def collect(patch: np.ndarray, weights: np.ndarray, patches: int) -> np.ndarray:
    """Sum of the weights of the rays that hit each patch.

    The sums of several clusters are merged by addition.

    Parameters
    ----------
    patch
        R int, the patch of each ray or -1.
    weights
        R int64, see `Hemisphere.weights`.
    patches
        Number of patches N.

    Returns
    -------
    N int64, in units of 2^-W.
    """
    hit = patch >= 0
    sums = np.zeros(patches, dtype=np.int64)
    np.add.at(sums, patch[hit], weights[hit])
    return sums
