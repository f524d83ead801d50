"""One caster of a method for all uses of a scene."""

from threading import Lock

from golden.cast.embree import Embree
from golden.cast.embree_library import has_embree
from golden.cast.grid import Grid
from golden.scene.scene import Scene

__all__ = ["SHARED", "default_method", "shared_caster"]

SHARED = {"grid": Grid, "embree": Embree}
"""The methods whose casters are shared: no cast changes them."""

_KEPT = "shared_casters"
_making = Lock()


def default_method() -> str:
    """The method that casts unless another one is named: embree where its wheel and numba are installed, else grid."""
    return "embree" if has_embree() else "grid"


def shared_caster(scene: Scene, method: str | None = None, jobs: int | None = None, progress: bool = False):
    """The caster of a scene with the method's defaults, made once and kept as long as the scene.

    Parameters
    ----------
    scene, progress
        See `golden.cast.grid.Grid`.
    method
        A name in `SHARED`. Default: the `default_method`.
    jobs
        Threads; casters of other numbers of threads are the same caster.
    """
    method = method or default_method()
    with _making:
        kept = vars(scene).setdefault(_KEPT, {})
        if method not in kept:
            kept[method] = SHARED[method](scene, jobs=jobs, progress=progress)
    return kept[method].with_jobs(jobs)
