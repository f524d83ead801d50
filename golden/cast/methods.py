"""Casting methods by name."""

from golden.cast.embree import Embree
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.cast.ray_caster import RayCaster
from golden.cast.shared_caster import SHARED, shared_caster
from golden.processors import threads_of
from golden.scene.scene import Scene

__all__ = ["FIXED_METHODS", "FRUSTUM_METHODS", "RAY_METHODS", "frustum_caster", "ray_caster", "shadow_caster"]


def _shelling(scene, cell=None):
    from golden.cast.fixed_frusta import ShellingFrusta

    return ShellingFrusta(scene, cell)


def _naive_fixed(scene):
    from golden.cast.fixed_frusta import NaiveFixedFrusta

    return NaiveFixedFrusta(scene)


# Methods that cast any rays; methods in fixed point, which cast frusta only; all that cast frusta.
# "naive" is brute force in float64, "naive-fixed" brute force in fixed point.
RAY_METHODS = {"grid": Grid, "naive": Naive, "embree": Embree}
FIXED_METHODS = {"shelling": _shelling, "naive-fixed": _naive_fixed}
FRUSTUM_METHODS = RAY_METHODS | FIXED_METHODS


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
        Threads; a method without them has one. Default: `golden.processors.processors`.
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


def frustum_caster(scene: Scene, method: str, *, cell: float | None = None, jobs: int | None = None,
                   progress: bool = False):
    """A caster of frusta by its name in `FRUSTUM_METHODS`; the other arguments are those of `ray_caster`."""
    threads_of(jobs)
    if method in RAY_METHODS:
        return ray_caster(scene, method, cell=cell, jobs=jobs, progress=progress)
    return _shelling(scene, cell) if method == "shelling" else FRUSTUM_METHODS[method](scene)


def shadow_caster(frusta):
    """The caster of frusta if it casts shadow rays together, else None."""
    return frusta if hasattr(frusta, "shadows") else None
