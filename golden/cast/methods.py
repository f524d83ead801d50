"""Casting methods by name."""

from golden.cast.fixed_frusta import NaiveFixedFrusta, ShellingFrusta
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.scene.scene import Scene

__all__ = ["FIXED_METHODS", "FRUSTUM_METHODS", "RAY_METHODS", "frustum_caster"]

# Methods in float64, which cast any rays; methods in fixed point, which cast frusta only; all that cast frusta.
# "naive" is brute force in float64, "naive-fixed" brute force in fixed point.
RAY_METHODS = {"grid": Grid, "naive": Naive}
FIXED_METHODS = {"shelling": ShellingFrusta, "naive-fixed": NaiveFixedFrusta}
FRUSTUM_METHODS = RAY_METHODS | FIXED_METHODS


def frustum_caster(scene: Scene, method: str, *, cell: float | None = None, jobs: int | None = None):
    """A caster of frusta by its name in `FRUSTUM_METHODS`.

    Parameters
    ----------
    scene, method
        The scene, and a name in `FRUSTUM_METHODS`.
    cell
        Cell size for methods with cells. Default: that of the method.
    jobs
        Threads for methods with threads. Default: that of the method.
    """
    if method == "grid":
        return Grid(scene, cell, jobs=jobs)
    return ShellingFrusta(scene, cell) if method == "shelling" else FRUSTUM_METHODS[method](scene)
