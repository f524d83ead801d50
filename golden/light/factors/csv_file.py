"""View factors as a table of comma-separated values."""

import csv
from pathlib import Path

import numpy as np

from golden.light.factors.factor_matrix import FactorMatrix
from golden.light.factors.receivers import ReceiverFactors

__all__ = ["BACKS", "GROUND", "SKY", "write_csv", "write_receivers"]

SKY, GROUND, BACKS = "(sky)", "(ground)", "(backs)"
"""Where radiation goes that meets no surface; the ground is what is below the horizon outside the scene."""

_COLUMNS = ("from", "area", "to", "view_factor", "standard_error")


def write_csv(factors: FactorMatrix, path: Path) -> None:
    """Write a line for each view factor that is not 0, by the names of surfaces, and those to `SKY` and `BACKS`.

    With patches of the sky, `SKY` is above the horizon and `GROUND` below it; without them `SKY` is both. The shares of
    one surface add up to 1. An error that is unknown is empty.
    """
    matrix = factors.F.tocoo()
    error = [""] * matrix.nnz if factors.error is None else factors.error.data.tolist()
    names, area = factors.surface.tolist(), factors.area.tolist()
    entries = [(row, names[column], value, spread) for row, column, value, spread in zip(
        matrix.row.tolist(), matrix.col.tolist(), matrix.data.tolist(), error, strict=True)]
    unknown = [""] * len(factors)
    sky_error = unknown if factors.sky_error is None else factors.sky_error.tolist()
    ground, ground_error = _ground(factors)
    for target, values, errors in ((SKY, factors.sky - ground, sky_error), (BACKS, factors.back, unknown),
                                   (GROUND, ground, unknown if ground_error is None else ground_error.tolist())):
        entries += [(row, target, values[row].item(), errors[row]) for row in np.flatnonzero(values).tolist()]
    entries.sort(key=lambda entry: entry[0])
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(
            [_COLUMNS, *((names[row], area[row], *rest) for row, *rest in entries if rest[1] > 0)])


def _ground(factors):
    """What leaves each patch below the horizon, 0 where the sky has no patches, and its standard error or None."""
    if factors.sky_patches is None:
        return np.zeros(len(factors)), None
    return (None if values is None else values[:, [0]].toarray().ravel()
            for values in (factors.sky_patches, factors.sky_patches_error))


def write_receivers(found: ReceiverFactors, path: Path) -> None:
    """Write a line for each view factor from a point that is not 0, by the number of the point from 0."""
    names = [*found.names, SKY, BACKS]
    point, target = np.nonzero(found.share)
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([
            ("receiver", "to", "view_factor", "standard_error"),
            *((one, names[other], value, error) for one, other, value, error in zip(
                point.tolist(), target.tolist(), found.share[point, target].tolist(),
                found.error[point, target].tolist(), strict=True))])
