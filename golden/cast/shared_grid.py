"""One grid for all uses of a scene by a command."""

from functools import lru_cache

from golden.cast.grid import Grid
from golden.scene.scene import Scene

__all__ = ["shared_grid"]


@lru_cache(maxsize=1)
def shared_grid(scene: Scene, jobs: int | None = None, progress: bool = False) -> Grid:
    """The grid of the last scene, with the default cell size; see `golden.cast.grid.Grid`."""
    return Grid(scene, jobs=jobs, progress=progress)
