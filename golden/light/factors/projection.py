"""The view factors nearest to an estimate that are closed and reciprocal."""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg

from golden.light.factors.entry_pairs import entry_pairs
from golden.light.factors.join import Estimate

__all__ = ["project"]

# Standard errors by which a factor may move, and a share outside: of thousands of those some are far off.
_REACH, _OUTSIDE_REACH = 2.0, 5.0

# Error of the closed forms, by which exact factors may move.
_CLOSED_FORMS = 1e-8

# Standard deviations, relative to the whole hemisphere, of the slack that names rows which nothing closes. From one to
# the next the multipliers of such rows grow; without the first ones a step of Newton's would send all rows far off.
_SLACKS = 1e-3, 1e-5, 1e-7, 1e-10

# Residual of a row's sum at which the search ends.
_EXACT = 1e-14

# Newton steps, halvings of one, and iterations of conjugate gradients in one.
_STEPS, _HALVINGS, _ITERATIONS = 200, 40, 500


def project(estimate: Estimate, *, area: np.ndarray,
            ignored: np.ndarray | None = None) -> tuple[sparse.csr_array, np.ndarray, np.ndarray]:
    """Minimise the sum of (change / standard error)^2 such that all rows close, with exact reciprocity.

    The unknowns are A_i F_ij of each pair once, A_i sky_i and A_i back_i, each at least 0. Factors stay within two
    standard errors of their estimates, shares outside within five. With a multiplier l_i for each row, an unknown is
    its estimate plus its variance times (l_i + l_j), clipped to its bounds; Newton steps on the N multipliers find the
    rows' sums. A row of which no ray left keeps a sky view factor of 0.

    Parameters
    ----------
    estimate
        Reciprocal estimates with standard errors.
    area
        N float64, areas of the sides.
    ignored
        N bool: rows that need not close. Default: none.

    Returns
    -------
    View factors, N x N csr_array with the estimate's pattern, and the shares that leave the scene and that meet a black
    back, N float64 each. A row that no change within the errors closes keeps a row sum other than 1.

    Source: R. P. Taylor and R. Luck, Comparison of reciprocity and closure enforcement methods for radiation view
    factors (1995), for least squares without bounds.
    """
    problem = _Problem(estimate, area, np.zeros(len(area), dtype=bool) if ignored is None else ignored)
    exchange, outside = problem.solve()
    count, indices, indptr = len(area), estimate.F.indices, estimate.F.indptr
    F = sparse.csr_array((exchange[problem.pair] / np.repeat(area, np.diff(indptr)), indices, indptr),
                         shape=(count, count))
    return F, outside[:count] / area, outside[count:] / area


class _Problem:
    """The dual problem, in units of each row's area."""

    def __init__(self, estimate, area, ignored):
        count, F = len(area), estimate.F
        self._area, self._ignored = area, ignored
        row, first, self.pair = entry_pairs(F.indices, F.indptr)
        self._low, self._high = row[first], F.indices[first]
        del row
        own = area[self._low]
        smaller = np.minimum(area[self._low], area[self._high])
        spread = np.maximum(estimate.error.data[first] * own, _CLOSED_FORMS * smaller)
        rows = np.arange(count, dtype=np.int32)
        self._value = np.concatenate([F.data[first] * own, estimate.sky * area, estimate.back * area])
        sky_error = np.where(estimate.sky > 0, estimate.sky_error, 0.0)
        self._spread = np.concatenate([spread, sky_error * area, estimate.back_error * area])
        self._rows = np.concatenate([self._low, rows, rows])

    def solve(self):
        """Exchange areas of the pairs, and areas times the shares outside, sky before back."""
        multiplier = np.zeros(len(self._area))
        for slack in _SLACKS:
            self._slack = slack * self._area
            multiplier, value = self._search(multiplier)
        pairs = len(self._high)
        return value[:pairs], value[pairs:]

    def _search(self, multiplier):
        """The multipliers and unknowns with the present slack."""
        value, merit, rest = self._at(multiplier)
        for _ in range(_STEPS):
            if np.abs(rest / self._area).max(initial=0) <= _EXACT:
                break
            step = self._newton_step(multiplier, rest)
            for halvings in range(_HALVINGS):
                trial = multiplier + step / 2**halvings
                trial_value, trial_merit, trial_rest = self._at(trial)
                # Near the end the merits differ by rounding alone, and the sums' own residual decides.
                alike = abs(trial_merit - merit) <= 1e-12 * self._area.sum()
                if (np.abs(trial_rest).sum() < 0.9 * np.abs(rest).sum()) if alike else trial_merit < merit:
                    break
            else:
                break
            multiplier, value, merit, rest = trial, trial_value, trial_merit, trial_rest
        return multiplier, value

    def _at(self, multiplier):
        """The unknowns that the multipliers give, the dual function, and what the rows' sums miss (minus its slope)."""
        pull = self._pull(multiplier)
        value = self._moved(pull)
        np.maximum(value, self._bound(-1), out=value)
        np.minimum(value, self._bound(1), out=value)
        merit = value @ pull
        change = np.subtract(value, self._value, out=pull)
        np.divide(change, self._spread, out=change, where=self._spread > 0)
        merit -= change @ change / 2
        del change, pull
        slack = self._slack**2 * multiplier
        rest = np.where(self._ignored, 0.0, self._area - self._sums(value) - slack)
        return value, merit + slack @ multiplier / 2 - self._area @ multiplier, rest

    def _newton_step(self, multiplier, rest):
        moves = self._moved(self._pull(multiplier))
        free = moves > self._bound(-1)
        free &= moves < self._bound(1)
        del moves
        variance = np.square(self._spread)
        variance *= free
        diagonal = self._sums(variance) + self._slack**2
        count, scale = len(rest), np.where(self._ignored, 0.0, 1 / np.sqrt(diagonal))
        # Pairs in their order are the entries above the diagonal of a symmetric matrix.
        start = np.searchsorted(self._low, np.arange(count + 1)).astype(np.int32)
        above = sparse.csr_array((variance[:len(self._high)], self._high, start), shape=(count, count))
        below = above.T

        def product(x):
            x = scale * x.ravel()
            return scale * (above @ x + below @ x)

        operator = LinearOperator((count, count), dtype=np.float64, matvec=lambda x: product(x) + x.ravel())
        return scale * cg(operator, scale * rest, rtol=1e-8, maxiter=_ITERATIONS)[0]

    def _moved(self, pull):
        """The unknowns without their bounds."""
        moved = self._spread * pull
        moved *= self._spread
        moved += self._value
        return moved

    def _bound(self, sign):
        """The least or the largest values of the unknowns."""
        bound = self._spread * sign
        bound[:len(self._high)] *= _REACH
        bound[len(self._high):] *= _OUTSIDE_REACH
        bound += self._value
        return np.maximum(bound, 0, out=bound)

    def _pull(self, multiplier):
        """The sum of the multipliers of each unknown's rows."""
        pull = multiplier[self._rows]
        pull[:len(self._high)] += multiplier[self._high]
        return pull

    def _sums(self, value):
        count, pairs = len(self._area), len(self._high)
        return np.bincount(self._rows, value, count) + np.bincount(self._high, value[:pairs], count)
