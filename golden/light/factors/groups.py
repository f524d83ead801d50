"""View factors between groups of patches, from those between the patches."""

from dataclasses import replace
from typing import TypeVar

import numpy as np
from scipy import sparse

from golden.light.factors.factor_matrix import FactorMatrix

__all__ = ["by_surface", "grouped", "surface_numbers"]

Factors = TypeVar("Factors", bound=FactorMatrix)


def grouped(factors: Factors, group: np.ndarray) -> Factors:
    """View factors of which patch k is all patches of group k together: means weighted by area.

    The share of group a that arrives at group b is the sum of A_i F_ij over i in a and j in b, over the area of a; so
    rows close and factors are reciprocal as those of the patches are. Pairs of patches count as independent: their
    variances add up, but F_ij and F_ji are one estimate. Closed rows are more certain than that.

    Parameters
    ----------
    factors
        Of N patches.
    group
        N int: the group of each, 0 to G - 1, none without a patch.

    Returns
    -------
    G patches with the name and the side of the first one of each group. ``normal`` is the mean by area, 0 if there is
    none; sums of rays are left out.
    """
    _, first, number = np.unique(group, return_index=True, return_counts=True)
    count = len(first)
    area = np.bincount(group, factors.area)
    share = factors.area / area[group]

    def mean(values):
        return None if values is None else np.bincount(group, share * values, count)

    def error_of_mean(values):
        return None if values is None else np.sqrt(np.bincount(group, (share * values)**2, count))

    F, unprojected, error = _means(factors.F, group, group, count, share, alike=factors.unprojected,
                                   error=factors.error)
    sky_patches = sky_patches_error = None
    if factors.sky_patches is not None:
        parts = factors.sky_patches.shape[1]
        sky_patches, _, sky_patches_error = _means(factors.sky_patches, group, np.arange(parts), parts, share,
                                                   error=factors.sky_patches_error)
    normal = np.stack([mean(axis) for axis in factors.normal.T], axis=1)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    # Of a factor that no pair of patches has: as many pairs as the largest group allows have the largest error.
    spread = float(np.sqrt(number.max() * np.bincount(group, share**2).max()))
    return replace(
        factors, F=F, error=error, unprojected=unprojected, sky=mean(factors.sky), back=mean(factors.back), area=area,
        normal=np.divide(normal, length, out=np.zeros_like(normal), where=length > 1e-9),
        surface=factors.surface[first], patch=np.arange(count), front=factors.front[first],
        hidden_error=factors.hidden_error * spread, sky_error=error_of_mean(factors.sky_error),
        unprojected_sky=mean(factors.unprojected_sky), sky_patches=sky_patches, sky_patches_error=sky_patches_error,
        row_sums=None, weight_bits=None)


def by_surface(factors: Factors) -> Factors:
    """View factors between surfaces: all patches of a name are one, those of their backs another one, ``NAME (back)``.

    Surfaces are in the order of their names.
    """
    number, names = surface_numbers(factors.surface, factors.front)
    return replace(grouped(factors, number), surface=np.array(names))


def surface_numbers(surface: np.ndarray, front: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """The surface of each of N sides by name and side, N int, and the names of the surfaces in their order."""
    sides = np.stack([np.unique(surface, return_inverse=True)[1], ~front])
    _, first, number = np.unique(sides, axis=1, return_index=True, return_inverse=True)
    return number.ravel(), [f"{surface[k]}{'' if front[k] else ' (back)'}" for k in first.tolist()]


def _means(whole: sparse.csr_array, group, columns, count, share, *, alike=None, error=None):
    """Means by groups of rows of a sparse matrix, and of another one of its pattern, and the first one's errors.

    ``columns`` has the group of each column, of ``count`` ones.
    """
    row = np.repeat(np.arange(whole.shape[0]), np.diff(whole.indptr))
    column = columns[whole.indices]
    key, place = np.unique(group[row] * np.int64(count) + column, return_inverse=True)
    rows = group.max() + 1
    start = np.searchsorted(key, np.arange(rows + 1) * count)

    def matrix(values):
        return sparse.csr_array((np.bincount(place, values, len(key)), key % count, start), shape=(rows, count))

    means = [None if one is None else matrix(share[row] * one.data) for one in (whole, alike)]
    if error is None:
        return *means, None
    # Within a group the two directions of a pair have one error: together they have twice it.
    is_double = (columns is group) & (group[row] == column) & (row != whole.indices)
    variance = matrix((1 + is_double) * (share[row] * error.data)**2)
    return *means, sparse.csr_array((np.sqrt(variance.data), variance.indices, variance.indptr), shape=variance.shape)
