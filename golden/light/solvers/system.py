"""The linear system whose solution is the radiosity of every patch."""

import numpy as np
from scipy import sparse

from golden.base.errors import InputError

__all__ = ["RadiositySystem"]


class RadiositySystem:
    """b = e + rho F b, for three colour channels at once.

    Radiosities are in units of radiance (B / pi), as emissions are.

    Parameters
    ----------
    form_factors
        N x N from row to column, an array or sparse. For shooting solvers also a function from k patches to their
        k x N sparse rows, which casts them on demand.
    reflectance
        N x 3, 0 to 1.
    emission
        N x 3, at least 0.
    area
        N, above 0.
    centre, normal
        N x 3 each, for solvers that search for neighbours; optional for all others.

    Members
    -------
    matrix
        The form factors, dense or sparse by rows; None if rows are cast on demand.

    Raises
    ------
    InputError
        Shapes do not match, a value is not finite or out of range.
    """

    def __init__(self, *, form_factors, reflectance, emission, area, centre=None, normal=None):
        self.area = _array("Area", area, None)
        count = len(self.area)
        self.reflectance = _array("Reflectance", reflectance, (count, 3))
        self.emission = _array("Emission", emission, (count, 3))
        self.centre = None if centre is None else _array("Centre", centre, (count, 3))
        self.normal = None if normal is None else _array("Normal", normal, (count, 3))
        if count == 0 or not (self.area > 0).all():
            raise InputError("radiosity: Area must be above 0 for at least one patch and all of them")
        if not ((self.reflectance >= 0) & (self.reflectance <= 1)).all():
            raise InputError(f"radiosity: Reflectance must be 0 to 1, not {self.reflectance.min()} "
                             f"to {self.reflectance.max()}")
        if not (self.emission >= 0).all():
            raise InputError(f"radiosity: Emission must be at least 0, not {self.emission.min()}")
        self._rows = form_factors if callable(form_factors) else None
        self.matrix = None if self._rows else _matrix(form_factors, count)
        self._by_column = None

    def __len__(self) -> int:
        return len(self.area)

    def residual(self, radiosity) -> np.ndarray:
        """Residual of ``radiosity``, e + rho F b - b: N x 3."""
        return self.emission + self.reflectance * (self.matrix @ radiosity) - radiosity

    def columns(self, patches) -> np.ndarray:
        """Share of k patches' light that reaches each patch, F_ji for k patches i: N x k.

        Of a stored matrix they are columns, so shooting and gathering solve the same system. On demand only the row of
        i is known; reciprocity replaces the column by F_ij A_i / A_j, exact as far as the rows obey it.
        """
        if self._rows:
            return np.ascontiguousarray(self._rows(patches).toarray().T) * self.area[patches] / self.area[:, None]
        if self._by_column is None:
            self._by_column = self.matrix.tocsc() if sparse.issparse(self.matrix) else np.asfortranarray(self.matrix)
        columns = self._by_column[:, patches]
        return columns.toarray() if sparse.issparse(columns) else columns


def _array(name, value, shape):
    value = np.array(value, dtype=np.float64)
    if value.shape != shape and (shape or value.ndim != 1):
        raise InputError(f"radiosity: {name} must be {'N' if shape is None else ' x '.join(map(str, shape))}, "
                         f"not {value.shape!r}")
    if not np.isfinite(value).all():
        raise InputError(f"radiosity: {name} must be finite")
    return value


def _matrix(factors, count):
    factors = sparse.csr_array(factors) if sparse.issparse(factors) else np.asarray(factors, dtype=np.float64)
    if factors.shape != (count, count):
        raise InputError(f"radiosity: Form factors must be {count} x {count}, not {factors.shape!r}")
    if not np.isfinite(factors.data if sparse.issparse(factors) else factors).all():
        raise InputError("radiosity: Form factors must be finite")
    return factors
