"""Single rays."""

from golden.base.errors import InputError
from golden.cast.methods import RAY_METHODS, check_cell, ray_caster
from golden.cast.rays import Hits, Rays
from golden.scene.scene import Scene

__all__ = ["cast"]


def cast(scene: Scene, rays: Rays, *, any_hit: bool = False, method: str = "grid", cell: float | None = None,
         jobs: int | None = None, progress: bool = False) -> Hits:
    """The hits of rays.

    Parameters
    ----------
    scene, rays
        The patches, and the rays.
    any_hit
        Whether any hit before ``rays.tmax`` suffices, in place of the nearest one.
    method
        How rays are cast: grid, naive or embree.
    cell
        Cell size of the grid, as a share of the scene's longest side; no other method has one. Default: by the number
        of patches.
    jobs
        Threads; the hits do not depend on them. Default: one per processor that this process may use.
    progress
        Shows a progress bar after two seconds of preparation.

    Raises
    ------
    InputError
        A parameter is out of range.
    """
    if method not in RAY_METHODS:
        raise InputError(f"cast: Method must be {' or '.join(RAY_METHODS)}, not {method!r}", parameter="method")
    check_cell(method, cell)
    caster = ray_caster(scene, method, cell=cell, jobs=jobs, progress=progress)
    return caster.any_hit(rays) if any_hit else caster.nearest(rays)
