"""View factors of a program's own geometry."""

from collections.abc import Callable

from golden.base.errors import InputError
from golden.cast.methods import RAY_METHODS, ray_caster
from golden.cast.shared_caster import default_method
from golden.light.factors.added_rays import add_rays, check_same_rows
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.rows import FactorRows
from golden.light.factors.units import METRES, in_metres
from golden.light.factors.view_factors import ViewFactors
from golden.scene.overlaps import warn_of_overlaps
from golden.scene.scene import Scene

__all__ = ["view_factors"]


def view_factors(geometry, *, names=None, two_sided: bool = False, error: float = 1e-3,
                 sky_error: float | None = None, sky_patches: str | None = None, seed: int = 0,
                 method: str | None = None, unit: str = "m", jobs: int | None = None, progress: bool = False,
                 more: ViewFactors | None = None, cancel: Callable[[], bool] | None = None) -> ViewFactors:
    """View factors between facets, with occlusion.

    >>> from golden import view_factors
    >>> factors = view_factors([[(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
    ...                         [(0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 1)]])
    >>> factors.F[0, 1].round(4)
    0.1998

    Parameters
    ----------
    geometry
        N x 4 x 3 or N x 3 x 3 corners of facets, counter-clockwise as seen from the front, in ``unit``; an object with
        such ``triangles``, as `trimesh.Trimesh`; or a `golden.scene.scene.Scene`.
    names
        N names of surfaces. Default: one for all.
    two_sided
        Whether the backs of facets radiate like their fronts, in N more rows. They block rays in any case.
    error
        Requested error of every factor, twice its standard error: 1e-6 to 0.1. A pair gets 2^22 segments at most, so
        ``largest_error`` of the result may be above it.
    sky_error
        The same of any sky view factor. Default: ``error`` as far as 4096 rays per side reach it.
    sky_patches
        "tregenza" or "reinhart": the shares of 145 or 577 patches of the sky as well.
    seed
        Of the random numbers, at least 0.
    method
        How rays are cast: embree, grid or naive. Default: embree where it is installed, else grid.
    unit
        Of length: m, mm, cm, km, in or ft. Areas are in m2.
    jobs
        Threads, 1 to 256; the factors do not depend on it. Default: one per processor that this
        process may use.
    progress
        Shows a progress bar after two seconds.
    more
        A result of the same geometry and options to which rays are added, in runs that halve its errors at most, until
        they are the requested ones.
    cancel
        Is called before each of these runs; says whether to return the result so far.

    Returns
    -------
    `ViewFactors`: ``F`` (`scipy.sparse.csr_array`, a row for each side), ``area``, ``sky``, ``error``, ``to_netcdf()``
    and more. Rows sum to 1 - sky - back, and A_i F_ij = A_j F_ji.

    Raises
    ------
    InputError
        The geometry or a parameter cannot be used.

    Warns
    -----
    InputWarning
        Facets overlap in one plane.
    """
    scene = geometry
    if not isinstance(geometry, Scene):
        scene = Scene.from_arrays(geometry, names=names, two_sided=two_sided)
    elif names is not None or two_sided:
        raise InputError("geometry: Names and sides must be those of the scene",
                         parameter="two_sided" if names is None else "names")
    method = method or default_method()
    if method not in RAY_METHODS:
        raise InputError(f"view factors: Method must be {' or '.join(RAY_METHODS)}, not {method!r}",
                         parameter="method")
    if unit not in METRES:
        raise InputError(f"view factors: Unit must be {' or '.join(METRES)}, not {unit!r}", parameter="unit")
    if more is not None and not isinstance(more, ViewFactors):
        raise InputError(f"view factors: More must be view factors, not {type(more).__name__}", parameter="more")
    warn_of_overlaps(scene)
    caster = ray_caster(scene, method, jobs=jobs)

    def rows(error, seed):
        return FactorRows(scene, caster, error=error, sky_error=sky_error, sky_patches=sky_patches, seed=seed)

    def run(error, seed):
        return in_metres(compute_view_factors(rows(error, seed), progress=progress), unit)

    if more is None:
        return run(error, seed)
    check_same_rows(more, rows(error, seed), unit)
    return add_rays(more, run, error=error, sky_error=sky_error, seed=seed, cancel=cancel)
