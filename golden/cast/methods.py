"""Ways to cast, by name."""

from golden.cast.fixed_frusta import NaiveFixedFrusta, ShellingFrusta
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.scene.scene import Scene

__all__ = ["FIXED_METHODS", "FRUSTUM_METHODS", "RAY_METHODS", "frustum_caster"]

# Those that cast any rays, those that cast frusta only, and together those that cast frusta.
RAY_METHODS = {"grid": Grid, "naive": Naive}
FIXED_METHODS = {"shelling": ShellingFrusta, "naive-fixed": NaiveFixedFrusta}
FRUSTUM_METHODS = RAY_METHODS | FIXED_METHODS


def frustum_caster(scene: Scene, method: str, *, cell: float | None = None, jobs: int | None = None):
    """A caster of frusta by its name in `FRUSTUM_METHODS`.

    Parameters
    ----------
    cell
        Cell size for methods that have cells. Default: theirs.
    jobs
        Threads for methods that have any. Default: theirs.
    """
    if method == "grid":
        return Grid(scene, cell, jobs=jobs)
    return ShellingFrusta(scene, cell) if method == "shelling" else FRUSTUM_METHODS[method](scene)
