"""View factors of a program's own geometry."""

from golden.cast.methods import RAY_METHODS, frustum_caster
from golden.errors import InputError
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.light.factors.meshes import geometry_scene
from golden.light.factors.view_factors import ViewFactors

__all__ = ["view_factors"]


def view_factors(geometry, *, names=None, two_sided: bool = False, method: str = "grid",
                 rays: tuple[int, int] = (256, 64), samples: int = 1, progress: bool = False) -> ViewFactors:
    """View factors between facets, with occlusion.

    >>> from golden import view_factors
    >>> factors = view_factors([[(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
    ...                         [(0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 1)]])
    >>> factors.F.shape
    (2, 2)

    Parameters
    ----------
    geometry
        N x 4 x 3 or N x 3 x 3 corners of facets, counter-clockwise as seen from the front, in any unit of length; a
        `trimesh.Trimesh`; or a `golden.scene.scene.Scene`.
    names
        N names of surfaces. Default: one for all.
    two_sided
        Whether the backs of facets radiate like their fronts. They block rays in any case.
    method
        How rays are cast: grid, naive or embree.
    rays
        Azimuths and polars of the hemispheres, powers of two.
    samples
        Gauss points along each side of a facet, 1 to 16, each with a hemisphere.
    progress
        Shows a progress bar after two seconds.

    Returns
    -------
    `ViewFactors`: ``F`` (N x N `scipy.sparse.csr_array`), ``area``, ``sky``, ``error``, ``to_netcdf()`` and more.

    Raises
    ------
    InputError
        The geometry or a parameter cannot be used.
    """
    scene = geometry_scene(geometry, names=names, two_sided=two_sided)
    if method not in RAY_METHODS:
        raise InputError(f"view factors: Method must be {' or '.join(RAY_METHODS)}, not {method!r}")
    rows = HemisphereRows(scene, frustum_caster(scene, method), rays=rays, samples=samples)
    return compute_view_factors(rows, progress=progress)
