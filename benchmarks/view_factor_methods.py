"""Methods of the literature that close view factors and make them reciprocal, beside the package's own.

Estimates of one scene to a coarse error are closed by each method and compared with view factors to a fine error.
"""

from collections.abc import Callable

import numpy as np

from golden.cast.grid import Grid
from golden.light.factors.join import Estimate, join
from golden.light.factors.projection import project
from golden.light.factors.rows import FactorRows
from golden.light.factors.sides import Sides
from golden.scene.scene import Scene

__all__ = ["METHODS", "method_rows"]

# Rounds of scaling, which ends when rows close within rounding.
_ROUNDS = 10_000


def scaling(estimate: Estimate, area: np.ndarray) -> np.ndarray:
    """Symmetric Sinkhorn scaling: exchange areas times a factor for each of both rows; for scenes without a sky."""
    exchange = estimate.F.toarray() * area[:, None]
    factor = np.ones(len(area))
    for _ in range(_ROUNDS):
        ratio = area / (factor * (exchange @ factor))
        if np.abs(ratio - 1).max() < 1e-13:
            break
        # The root makes the alternation of Sinkhorn's algorithm symmetric.
        factor *= np.sqrt(ratio)
    return factor[:, None] * exchange * factor / area[:, None]


def least_squares(estimate: Estimate, area: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """The least sum of squared changes of exchange areas over a variance, N x N, without bounds; for closed scenes.

    Source: Taylor, Luck, Comparison of reciprocity and closure enforcement methods for radiation view factors (1995).
    """
    exchange = estimate.F.toarray() * area[:, None]
    system = variance + np.diag(variance.sum(axis=1))
    multiplier = np.linalg.lstsq(system, area - exchange.sum(axis=1))[0]
    return (exchange + variance * (multiplier[:, None] + multiplier)) / area[:, None]


def _by_errors(estimate, area):
    spread = np.maximum(estimate.error.toarray() * area[:, None], 1e-8 * np.minimum(area[:, None], area))
    return least_squares(estimate, area, np.where(estimate.F.toarray() > 0, spread**2, 0.0))


METHODS: dict[str, Callable[[Estimate, np.ndarray], np.ndarray]] = {
    "none": lambda estimate, area: estimate.F.toarray(),
    "symmetric Sinkhorn scaling": scaling,
    "least squares, equal weights": lambda estimate, area: least_squares(
        estimate, area, (estimate.F.toarray() > 0).astype(float)),
    "least squares, relative changes": lambda estimate, area: least_squares(
        estimate, area, (estimate.F.toarray() * area[:, None])**2),
    "least squares by standard errors": _by_errors,
    "the same within two standard errors (built)": lambda estimate, area: project(estimate, area=area)[0].toarray()}


def method_rows(facets: np.ndarray, *, coarse: float, fine: float) -> list[list]:
    """Of each method: closure, entries below 0, largest change of an exact factor, and RMS error of all entries.

    Parameters
    ----------
    facets
        N x 4 x 3, of a closed scene.
    coarse, fine
        Requested errors of the estimates and of what they are compared with.
    """
    scene = Scene.from_arrays(facets)
    area, grid = Sides(scene).area, Grid(scene)

    def estimate_to(error, seed):
        rows = FactorRows(scene, grid, error=error, seed=seed)
        return join([rows.rows(0, len(rows))], area=area, error=error)

    estimate = estimate_to(coarse, 0)
    truth = project(estimate_to(fine, 1), area=area)[0].toarray()
    measured, rows = estimate.F.toarray(), []
    exact = (estimate.error.toarray() == 0) & (measured > 0)
    for name, method in METHODS.items():
        F = method(estimate, area)
        rows.append([name, np.abs(F.sum(axis=1) - 1).max(), int((F < -1e-12).sum()),
                     np.abs(F - measured)[exact].max(), np.sqrt(np.mean((F - truth)**2))])
    return rows
