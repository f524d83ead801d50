"""View factors of several runs together: more rays for a result that there is already."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import sparse

from golden.base.errors import InputError
from golden.light.factors.rows import FactorRows
from golden.light.factors.view_factors import ViewFactors

__all__ = ["add_rays", "check_same_rows", "combined", "runs_of"]

# Weight of the next run over that of all before it: their error halves.
_GROWTH = 3
# The least and the largest error that a run may have.
_FINEST, _COARSEST = 1e-6, 0.1


def runs_of(factors: ViewFactors) -> list[tuple[float, int]]:
    """The requested error and the seed of each run of a result.

    Raises
    ------
    InputError
        Its errors are unknown: it is of plain hemispheres.
    """
    if factors.error is None or factors.sky_error is None or "error" not in factors.settings:
        raise InputError("view factors: More must be view factors with errors", parameter="more")
    return [tuple(run) for run in factors.settings.get("runs", [(factors.settings["error"], factors.settings["seed"])])]


def check_same_rows(factors: ViewFactors, rows: FactorRows, unit: str) -> None:
    """A result has errors, and is of these rows in this unit: its settings differ in errors and seeds alone.

    Raises
    ------
    InputError
        It is not.
    """
    runs_of(factors)  # which checks it
    mine, others = ({name: value for name, value in settings.items() if name not in ("error", "seed", "sky_error",
                                                                                      "runs")}
                    for settings in ({"unit": "m"} | factors.settings, rows.settings | {"unit": unit}))
    if mine != others:
        name = min(name for name in mine.keys() | others.keys() if mine.get(name) != others.get(name))
        raise InputError(f"view factors: More must be view factors of the same {name}, not of {mine.get(name)!r}",
                         parameter="more")
    if len(factors) != len(rows):
        raise InputError("view factors: More must be view factors of the same patches", parameter="more")


def combined(first: ViewFactors, second: ViewFactors, *, error: float, sky_error: float | None = None) -> ViewFactors:
    """The mean of two independent results, weighted by the squares of their requested errors.

    A mean of rows that close closes, and one of reciprocal factors is reciprocal. A factor that one of them has no
    entry for is 0 there, with the standard error of such a factor. A patch of the sky that a row of one has no entry
    for has the least error of the row's others there, and if there are none that of the row's sky.

    Parameters
    ----------
    first, second
        Of the same rows.
    error, sky_error
        Those that the settings of the result name as requested. Default of the sky's: that of ``first``.
    """
    runs = [*runs_of(first), *runs_of(second)]
    weights = [sum(size**-2.0 for size, _ in runs_of(one)) for one in (first, second)]
    shares = [weight / sum(weights) for weight in weights]
    F, spread, unprojected = _mean(first, second, shares, ("F", "error", "unprojected"), [
        np.full(len(one), one.largest_absent / 2) for one in (first, second)])
    sky = {}
    if first.sky_patches is not None:
        sky["sky_patches"], sky["sky_patches_error"], _ = _mean(first, second, shares,
                                                               ("sky_patches", "sky_patches_error", "sky_patches"),
                                                               [_of_absent_sky(one) for one in (first, second)])

    def mean(name):
        return sum(share * getattr(one, name) for share, one in zip(shares, (first, second), strict=True))

    return replace(
        first, F=F, error=spread, unprojected=unprojected, sky=mean("sky"), back=mean("back"),
        unprojected_sky=mean("unprojected_sky"), sky_error=np.hypot(*(
            share * one.sky_error for share, one in zip(shares, (first, second), strict=True))),
        hidden_error=float(np.hypot(*(share * one.largest_absent / 2
                                      for share, one in zip(shares, (first, second), strict=True)))),
        settings=first.settings | {"error": error, "runs": [list(run) for run in runs]}
        | ({} if sky_error is None else {"sky_error": sky_error}), **sky)


def add_rays(stored: ViewFactors, run: Callable[[float, int], ViewFactors], *, error: float, sky_error: float | None,
             seed: int, cancel: Callable[[], bool] | None = None) -> ViewFactors:
    """A result with runs added until its errors are the requested ones; each run halves them at most.

    Parameters
    ----------
    stored
        The result, of the rows of ``run`` (`check_same_rows`).
    run
        Function from a requested error and a seed to the view factors of the same rows.
    error, sky_error
        The requested errors, the sky's of its patches too; None: the sky's does not matter.
    seed
        The least seed of the runs, which take those that no run has had.
    cancel
        Is called before each run and says whether to return what there is.
    """
    while stored.largest_error > error or (sky_error is not None and sky_error < max(
            stored.largest_sky_error, stored.largest_sky_patch_error or 0)):
        if cancel is not None and cancel():
            break
        runs = runs_of(stored)
        weight = sum(size**-2.0 for size, _ in runs)
        missing = error**-2.0 - weight
        share = min(missing, _GROWTH * weight) if missing > 0 else weight / len(runs)
        taken = {number for _, number in runs}
        number = next(one for one in range(seed, seed + len(taken) + 1) if one not in taken)
        found = run(float(np.clip(share**-0.5, _FINEST, _COARSEST)), number)
        stored = combined(stored, found, error=error, sky_error=sky_error)
    return stored


def _of_absent_sky(factors):
    """The standard error of a patch of the sky without an entry, for each row.

    That of a patch that no ray met is the least that `patch_errors` gives.
    """
    errors = factors.sky_patches_error
    result = factors.sky_error.copy()
    has = np.flatnonzero(np.diff(errors.indptr))
    if len(has):
        result[has] = np.minimum.reduceat(errors.data, errors.indptr[has])
    return result


def _mean(first, second, shares, names, absent):
    """Weighted means of two sparse matrices, their standard errors, and the means of a third pair of their patterns.

    ``absent``: for each row of both the standard error of what is no entry.
    """
    matrices = [[getattr(one, name) for name in names] for one in (first, second)]
    pattern = sum(sparse.csr_array((np.ones(value.nnz), value.indices, value.indptr), shape=value.shape)
                  for value, _, _ in matrices)
    pattern.sort_indices()
    columns = pattern.shape[1]
    row = np.repeat(np.arange(pattern.shape[0], dtype=np.int64), np.diff(pattern.indptr))
    keys = row * columns + pattern.indices
    sums, variance, others = np.zeros((3, len(keys)))
    for missing, share, (value, error, other) in zip(absent, shares, matrices, strict=True):
        own = np.repeat(np.arange(value.shape[0], dtype=np.int64), np.diff(value.indptr)) * columns + value.indices
        place = np.searchsorted(keys, own)
        deviation = missing[row]
        deviation[place] = error.data
        variance += (share * deviation)**2
        np.add.at(sums, place, share * value.data)
        np.add.at(others, place, share * other.data)
    return [sparse.csr_array((values, pattern.indices, pattern.indptr), shape=pattern.shape)
            for values in (sums, np.sqrt(variance), others)]
