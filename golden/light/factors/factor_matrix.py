"""View factors between the patches of a scene, as numbers with what describes them."""

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse

from golden.base.errors import InputError
from golden.base.plural import counted

__all__ = ["CLOSED", "FactorMatrix"]

# Above so many requested errors an error is not a rounding of it.
_MISSED = 1 + 1e-9

# A row that misses 1 by at most this is closed.
CLOSED = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class FactorMatrix:
    """View factors between N patches: F[i, j] is the share of the radiation that leaves i and arrives at j.

    Arrays may be changed in place: all that follows from them, such as `closure`, is computed at each use.

    Parameters
    ----------
    F
        N x N sparse `scipy.sparse.csr_array` of float64, from patch i (row) to patch j.
    sky, back
        N float64: the share that leaves the scene, the sky view factor, and the share that meets the black back of a
        one-sided patch.
    area
        N float64, areas of the patches in m2.
    normal
        N x 3 float64, unit normals out of the sides: of a back that of the front reversed.
    surface
        N str: name of the surface that each patch belongs to.
    patch, front
        N int and N bool: the patch of the scene, and whether the row is its front. A two-sided patch may have a row for
        each side.
    error
        Standard error of each entry, sparse with the pattern of ``F``; 0 exactly where the entry is exact. None if it
        is unknown.
    hidden_error
        Largest standard error of a factor that is no entry of ``F``.
    sky_error
        N float64: standard error of ``sky``. None if it is unknown.
    sky_patches
        N x P sparse csr_array: the share that leaves through each patch of the sky, see
        `golden.light.factors.sky_division.SkyDivision`. Rows sum to ``sky``. None if they were not requested.
    sky_patches_error
        Standard error of each entry of ``sky_patches``, of the same pattern. None if it is unknown.
    unprojected, unprojected_sky
        ``F`` (sparse, of the same pattern) and ``sky`` as measured, before closure and reciprocity were enforced. None
        if they were not enforced.
    row_sums, weight_bits
        Of casting on fixed points: N x samples int64, the weights of the rays of each hemisphere that hit a patch, in
        units of 2^-weight_bits. None otherwise.
    settings
        Names and values of what the result depends on.

    Raises
    ------
    InputError
        Shapes or patterns do not match, or a value is not finite or is negative.
    """

    F: sparse.csr_array
    sky: np.ndarray
    back: np.ndarray
    area: np.ndarray
    normal: np.ndarray
    surface: np.ndarray
    patch: np.ndarray
    front: np.ndarray
    error: sparse.csr_array | None = None
    hidden_error: float = 0.0
    sky_error: np.ndarray | None = None
    sky_patches: sparse.csr_array | None = None
    sky_patches_error: sparse.csr_array | None = None
    unprojected: sparse.csr_array | None = None
    unprojected_sky: np.ndarray | None = None
    row_sums: np.ndarray | None = None
    weight_bits: int | None = None
    settings: dict = field(default_factory=dict)

    def __post_init__(self):
        count = len(self.area)
        shapes = {"F": (count, count), "sky": (count,), "back": (count,), "area": (count,), "normal": (count, 3),
                  "surface": (count,), "patch": (count,), "front": (count,), "error": (count, count),
                  "unprojected": (count, count), "unprojected_sky": (count,), "sky_error": (count,)}
        if self.sky_patches is not None:
            shapes["sky_patches"] = shapes["sky_patches_error"] = count, self.sky_patches.shape[1]
        for name, shape in shapes.items():
            value = getattr(self, name)
            if value is None:
                continue
            if value.shape != shape:
                raise InputError(f"view factors: {name} must be {' x '.join(map(str, shape))}, not {value.shape!r}")
            numbers = value.data if sparse.issparse(value) else value
            if name != "surface" and not np.isfinite(numbers).all():
                raise InputError(f"view factors: {name} must be finite")
            if name not in ("surface", "normal") and (numbers < 0).any():
                raise InputError(f"view factors: {name} must be at least 0")
        for name, of in (("error", "F"), ("unprojected", "F"), ("sky_patches_error", "sky_patches")):
            value, whole = getattr(self, name), getattr(self, of)
            if value is not None and not (whole is not None and np.array_equal(value.indptr, whole.indptr)
                                          and np.array_equal(value.indices, whole.indices)):
                raise InputError(f"view factors: {name} must have the pattern of {of}")

    def __len__(self) -> int:
        return len(self.area)

    @property
    def closure(self) -> float:
        """Largest absolute difference of a row sum plus sky and back from 1."""
        return float(np.abs(self.F.sum(axis=1) + self.sky + self.back - 1).max())

    @property
    def reciprocity(self) -> float:
        """Sum of |A_i F_ij - A_j F_ji| over the sum of A_i F_ij; 0 if F has no entries."""
        F = self.F
        exchange = sparse.csr_array((F.data * np.repeat(self.area, np.diff(F.indptr)), F.indices, F.indptr),
                                    shape=F.shape)
        total = exchange.data.sum()
        return float(np.abs((exchange - exchange.T).data).sum() / total) if total else 0.0

    @property
    def largest_error(self) -> float | None:
        """Estimated absolute error of the least certain factor: twice its standard error; None if it is unknown."""
        return None if self.error is None else 2 * float(self.error.data.max(initial=self.hidden_error))

    @property
    def largest_absent(self) -> float | None:
        """Estimated bound of a factor that is no entry; None if errors are unknown.

        Segments that all were blocked leave twice `hidden_error`, and a pair whose factor without occlusion is at most
        half of the requested error has an entry only if a ray met it. One that was `truncated` was measured below the
        limit, to the requested error.
        """
        if self.error is None:
            return None
        error, dropped = self.settings.get("error", 0), self.settings.get("drop_below")
        return max(2 * self.hidden_error, error / 2 if dropped is None else dropped + error)

    @property
    def largest_sky_patch_error(self) -> float | None:
        """Estimated absolute error of the least certain share of a patch of the sky; None if it is unknown."""
        return None if self.sky_patches_error is None else 2 * float(self.sky_patches_error.data.max(initial=0))

    @property
    def largest_sky_error(self) -> float | None:
        """Estimated absolute error of the least certain sky view factor; None if it is unknown."""
        return None if self.sky_error is None else 2 * float(self.sky_error.max())

    @property
    def infeasible(self) -> np.ndarray:
        """The rows that the projection could not close within the errors; none without one."""
        if self.unprojected is None:
            return np.zeros(0, dtype=np.int64)
        return np.flatnonzero(np.abs(self.F.sum(axis=1) + self.sky + self.back - 1) > CLOSED)

    @property
    def missed(self) -> np.ndarray:
        """The rows with an entry whose estimated error is above the requested one; none if none was requested."""
        if self.error is None or "error" not in self.settings:
            return np.zeros(0, dtype=np.int64)
        wrong = 2 * self.error.data > _MISSED * self.settings["error"]
        return np.unique(np.repeat(np.arange(len(self)), np.diff(self.error.indptr))[wrong])

    @property
    def sky_missed(self) -> np.ndarray:
        """The rows whose estimated error of the sky, or of a patch of it, is above the requested one.

        None if none was requested.
        """
        if self.sky_error is None or "sky_error" not in self.settings:
            return np.zeros(0, dtype=np.int64)
        worst = self.sky_error
        if self.sky_patches_error is not None:
            worst = np.maximum(worst, self.sky_patches_error.max(axis=1).toarray().ravel())
        return np.flatnonzero(2 * worst > _MISSED * self.settings["sky_error"])

    @property
    def largest_change(self) -> float | None:
        """Largest change of an entry by the projection; None without one."""
        return None if self.unprojected is None else float(np.abs(self.F.data - self.unprojected.data).max(initial=0))

    @property
    def sky_change(self) -> float | None:
        """Largest change of a sky view factor by the projection; None without one."""
        return None if self.unprojected_sky is None else float(np.abs(self.sky - self.unprojected_sky).max())

    def __repr__(self) -> str:
        error = "unknown" if self.error is None else f"{self.largest_error:.1e}"
        return (f"<{type(self).__name__}: {counted(len(self), 'row')}, {self.F.nnz} entries, error {error}, "
                f"closure {self.closure:.1e}>")
