"""All methods that cast frusta, by name: of any rays in float64, and of frusta in the machine's integers."""

from golden.base.processors import threads_of
from golden.cast.methods import RAY_METHODS, ray_caster
from golden.scene.scene import Scene

__all__ = ["FIXED_METHODS", "FRUSTUM_METHODS", "frustum_caster"]


# Names alone load nothing of the machine.
def _shelling(scene, cell=None):
    from golden.engine.cast.fixed_frusta import ShellingFrusta

    return ShellingFrusta(scene, cell)


def _naive_fixed(scene):
    from golden.engine.cast.fixed_frusta import NaiveFixedFrusta

    return NaiveFixedFrusta(scene)


# "naive-fixed" is brute force.
FIXED_METHODS = {"shelling": _shelling, "naive-fixed": _naive_fixed}
FRUSTUM_METHODS = RAY_METHODS | FIXED_METHODS


def frustum_caster(scene: Scene, method: str, *, cell: float | None = None, jobs: int | None = None,
                   progress: bool = False):
    """A caster of frusta by its name in `FRUSTUM_METHODS`; the other arguments are those of `ray_caster`."""
    threads_of(jobs)
    if method in RAY_METHODS:
        return ray_caster(scene, method, cell=cell, jobs=jobs, progress=progress)
    return _shelling(scene, cell) if method == "shelling" else FRUSTUM_METHODS[method](scene)
