"""Shares measured by rays or segments in replicates, with standard errors."""

import numpy as np

from golden.light.factors.points import REPLICATES

__all__ = ["replicate_shares"]

# From so many of the rarer kind on, the replicates' own scatter estimates the variance: by half of Student's factor
# that has the normal distribution's confidence at two standard deviations.
_COMMON = 16
_STUDENT = 2.181 / 2

# A replicate of n equal weights is at best the true share rounded up or down to a multiple of 1 / n. If all replicates
# agree, Wilson's error of `REPLICATES` trials is left, in units of 1 / n.
_LEAST = 2 * REPLICATES / (REPLICATES + 4)


def replicate_shares(whole: np.ndarray, part: np.ndarray, squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The share of a part in the whole, and its standard error; by Wilson where the replicates do not
    estimate it.

    Parameters
    ----------
    whole, part
        P x `REPLICATES` float64: weights of what was drawn, and of those drawn that belong to the part.
    squares
        P float64: sums of the squared weights.

    Returns
    -------
    P float64 each: the share, 0.5 where nothing was drawn, and exactly 0 or 1 where all agreed; and the standard error.

    Source: Wilson, Probable inference, the law of succession, and statistical inference (1927).
    """
    total, seen = whole.sum(axis=1), part.sum(axis=1)
    some = total > 0
    share = np.divide(seen, total, out=np.full(len(total), 0.5), where=some)
    share = np.where(seen == total, np.where(some, 1.0, 0.5), share)
    size = np.divide(total**2, squares, out=np.zeros(len(total)), where=some)
    # Half of the distance to the farther end of Wilson's interval at two standard deviations.
    error = (np.abs(1 - 2 * share) + np.sqrt(size * share * (1 - share) + 1)) / (size + 4)
    rest = part - share[:, None] * whole
    scatter = _STUDENT * np.sqrt(np.einsum("pr,pr->p", rest, rest) * REPLICATES / (REPLICATES - 1))
    common = (np.minimum(share, 1 - share) * size >= _COMMON) & (whole > 0).all(axis=1)
    scatter = np.divide(scatter, total, out=np.zeros(len(total)), where=some)
    error = np.where(common, np.maximum(scatter, _LEAST / np.maximum(size, 1)), error)
    return share, np.where(some, error, 0.5)
