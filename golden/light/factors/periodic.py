"""View factors of a scene that repeats without end, such as a part of a city."""

from dataclasses import replace

import numpy as np

from golden.base.errors import InputError
from golden.light.factors.rows import FactorRows
from golden.light.factors.sides import Sides
from golden.scene.scene import Scene
from golden.scene.sky.compass import compass

__all__ = ["PeriodicRows", "tiled"]

# Copies on each side reach so many heights of the scene, as far as so many copies do.
_HEIGHTS, _MOST = 10, 5


def tiled(scene: Scene, period: tuple[float, float]) -> Scene:
    """The scene, and behind its patches those of its copies around it.

    Copies reach ten heights of the scene in each direction, as far as five copies do.

    Parameters
    ----------
    scene
        A scene of one-sided patches.
    period
        Distances of the copies to the east and to the north (`compass`); as long as the scene at least.

    Raises
    ------
    InputError
        Patches are two-sided, or a period is shorter than the scene.
    """
    if scene.two_sided.any():
        raise InputError(f"scene {scene.name!r}: its patches must have fronts alone to repeat (--facets)")
    axes = compass(scene.up)
    extent = np.ptp(scene.vertices.reshape(-1, 3) @ axes.T, axis=0)
    if not (np.isfinite(period).all() and (np.array(period) >= (1 - 1e-9) * extent[:2]).all()):
        raise InputError(f"view factors: Period must be at least {extent[0]:g},{extent[1]:g}, the scene's own size, "
                         f"not {period[0]:g},{period[1]:g}", parameter="period")
    reach = int(np.clip(np.ceil(_HEIGHTS * extent[2] / min(period)), 1, _MOST))
    steps = np.array([(i, j) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)])
    steps = steps[np.argsort((steps != 0).any(axis=1), kind="stable")]
    shift = steps * period @ axes[:2]
    vertices = (scene.vertices + shift[:, None, None, None]).reshape(-1, 4, 3)
    surface = scene.surface + np.arange(len(shift))[:, None] * (scene.surface.max() + 1)
    return replace(scene, vertices=vertices, material=np.tile(scene.material, len(shift)), surface=surface.ravel(),
                   smooth=None, two_sided=np.tile(scene.two_sided, len(shift)), textures=None)


class PeriodicRows(FactorRows):
    """Rows of a scene that repeats: a column is a patch and all its copies together.

    So rows close, and the factors are reciprocal, as those of a scene alone. What leaves the copies counts as sky.

    Parameters
    ----------
    scene, period
        The scene and its period, see `tiled`.
    tiles, caster
        The scene with its copies, and a caster of these.
    options
        Those of `FactorRows`.
    """

    def __init__(self, scene: Scene, period: tuple[float, float], tiles: Scene, caster, **options):
        super().__init__(tiles, caster, **options)
        self._own = Sides(scene)
        self.settings |= {"period": list(map(float, period))}

    def _block(self, first, last, *, rays, limit, all_pairs=False):
        # The row of a copy, which is to measure the pair in other scenes, is not there.
        block, width = super()._block(first, last, rays=rays, limit=limit, all_pairs=True), len(self)
        row = np.repeat(np.arange(last - first), np.diff(block.start))
        key, place = np.unique(row * np.int64(width) + block.column % width, return_inverse=True)
        count = block.rays[row]
        is_hit = np.isnan(block.factor)
        factor = np.where(is_hit, block.hits / count, block.factor)
        # A pair without segments has a factor of at most half of the error.
        error = np.where(is_hit, np.minimum(np.sqrt(block.hits + 0.5) / count, limit), block.error)
        return replace(block, start=np.searchsorted(key, np.arange(last - first + 1) * width),
                       column=(key % width).astype(np.int32),
                       hits=np.bincount(place, block.hits, len(key)).astype(np.int32),
                       factor=np.bincount(place, factor, len(key)),
                       error=np.sqrt(np.bincount(place, error**2, len(key))))
