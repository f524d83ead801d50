"""One grid for all uses of a scene."""

from threading import Lock

from golden.cast.grid import Grid
from golden.scene.scene import Scene

__all__ = ["shared_grid"]

_KEPT = "shared_grid"
_making = Lock()


def shared_grid(scene: Scene, jobs: int | None = None, progress: bool = False) -> Grid:
    """The grid of a scene with the default cell size, made once and kept as long as the scene.

    Parameters
    ----------
    scene, progress
        See `golden.cast.grid.Grid`.
    jobs
        Threads; grids of other numbers of threads are the same grid.
    """
    with _making:
        if _KEPT not in vars(scene):
            vars(scene)[_KEPT] = Grid(scene, jobs=jobs, progress=progress)
    return vars(scene)[_KEPT].with_jobs(jobs)
