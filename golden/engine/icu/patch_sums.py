"""Sums of a section: per patch, of the form-factor weights of the rays that hit it."""

from dataclasses import dataclass

import numpy as np

from golden.engine.memory_map.layout import WEIGHT_BITS

__all__ = ["SUM_BITS", "SectionSums", "section_sums"]

# Of a sum; those of a hemisphere are 2^40 together at most.
SUM_BITS = WEIGHT_BITS


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionSums:
    """The sums of a section's weights.

    Parameters
    ----------
    patch, sum
        K int64: the patches that occur among the hits with a weight that is not 0, in the order of their first
        occurrences, and the sums of their weights.
    overflow
        The first of these patches whose sum does not fit its word, or -1.
    """

    patch: np.ndarray
    sum: np.ndarray
    overflow: int


def section_sums(patch: np.ndarray, weight: np.ndarray) -> SectionSums:
    """The sums of a section, from its hits in the order of read-out.

    Parameters
    ----------
    patch
        R int64, -1 for no hit.
    weight
        R int64, the weight of each ray.
    """
    counted = np.flatnonzero((patch >= 0) & (weight != 0))
    found, first, which = np.unique(patch[counted], return_index=True, return_inverse=True)
    sums = np.zeros(len(found), dtype=np.int64)
    np.add.at(sums, which, weight[counted])
    order = np.argsort(first)
    over = np.flatnonzero(sums[order] >> SUM_BITS)
    return SectionSums(patch=found[order], sum=sums[order], overflow=int(found[order][over[0]]) if len(over) else -1)
