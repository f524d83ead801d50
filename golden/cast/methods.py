"""Methods that cast any rays, by name."""

from golden.base.errors import InputError
from golden.base.processors import threads_of
from golden.cast.embree import Embree
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.cast.ray_caster import RayCaster
from golden.cast.shared_caster import SHARED, shared_caster
from golden.scene.cells import check_cell_size
from golden.scene.scene import Scene

__all__ = ["RAY_METHODS", "check_cell", "ray_caster", "shadow_caster"]


# "naive" is brute force.
RAY_METHODS = {"grid": Grid, "naive": Naive, "embree": Embree}
# Of methods of frusta too.
_WITHOUT_CELLS = ("naive", "naive-fixed", "embree")


def check_cell(method: str, cell: float | None) -> None:
    """A user's cell size is one of a method with cells, and in range; None is the method's own.

    Raises
    ------
    InputError
        It is not.
    """
    if cell is None:
        return
    if method in _WITHOUT_CELLS:
        raise InputError(f"Cell size must be left out with method {method}, which has no cells, not {cell!r}",
                         parameter="cell")
    check_cell_size(cell)


def ray_caster(scene: Scene, method: str, *, cell: float | None = None, jobs: int | None = None,
               progress: bool = False) -> RayCaster:
    """A caster of any rays by its name in `RAY_METHODS`.

    Parameters
    ----------
    scene, method
        The scene, and a name in `RAY_METHODS`.
    cell
        Cell size for methods with cells. Default: that of the method.
    jobs
        Threads; a method without them has one. Default: `golden.base.processors.processors`.
    progress
        Shows a progress bar after two seconds of preparation.

    Raises
    ------
    ModuleNotFoundError
        The package of the method is not installed.
    InputError
        The number of threads is out of range, whether the method has threads or not.
    """
    threads_of(jobs)
    if method == "grid" and cell is not None:
        return Grid(scene, cell, jobs=jobs, progress=progress)
    return shared_caster(scene, method, jobs, progress) if method in SHARED else RAY_METHODS[method](scene)


def shadow_caster(frusta):
    """The caster of frusta if it casts shadow rays together, else None."""
    return frusta if hasattr(frusta, "shadows") else None
