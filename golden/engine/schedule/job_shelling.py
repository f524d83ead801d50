"""The cells of a job, in lists that keep a machine's tests and patch setup busy at the same time."""

from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.scene.patch_geometry import PatchGeometry

__all__ = ["job_shelling"]


def job_shelling(geometry: PatchGeometry, config: Config, *, cell: float, by_code: bool = False) -> Shelling:
    """Shelling in the cells that the host gives a machine.

    Lists longer than the intersection unit's slots are scattered, so that patches with many tests and patches with few
    alternate: the slots even out short runs of either. A machine with subshell lists, which is the thesis', has
    ascending lists.

    Parameters
    ----------
    geometry, config, cell, by_code
        See `Shelling`.

    Raises
    ------
    InputError
        Cell size out of range.
    """
    ascending = None if config.ctu.subshells else config.icu.slots
    return Shelling(geometry, config, cell=cell, by_code=by_code, ascending=ascending)
