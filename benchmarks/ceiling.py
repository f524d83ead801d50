"""Hemispheres from points of a scene's ceiling: what several benchmarks cast."""

from functools import cached_property

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord, hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.phase import Schedule, schedule
from golden.scene.open import open_scene

__all__ = ["CELL", "HEMISPHERE", "POINTS", "RATIO", "SCENES", "Ceiling"]

SCENES = ("lobby", "room1627", "cubes", "man", "phone")
CELL, HEMISPHERE, RATIO = 0.0625, Hemisphere(256, 64), 64
# The points between which the thesis' phases run, counted from 0.
POINTS = (3, 6, 9, 12)


class Ceiling:
    """A scene, and hemispheres into it from 16 points of its ceiling.

    Parameters
    ----------
    name
        The scene's name.
    config
        The configuration.
    cell, hemisphere
        Size of the cells, and the rays of each frustum.
    point
        The only one of the points. Default: all of them.
    options
        More parameters of `Shelling`.

    Members
    -------
    scene, points, geometry, shelling
        The scene, the points, its patches as seen from them, and shelling.
    """

    def __init__(self, name: str, config: Config, *, cell: float = CELL, hemisphere: Hemisphere = HEMISPHERE,
                 point: int | None = None, **options):
        self._config, self._hemisphere, self._options = config, hemisphere, {"cell": cell, **options}
        self.scene = open_scene(name)
        points, self._down = ceiling_points(self.scene)
        self.points = points if point is None else points[[point]]
        self.geometry = PatchGeometry.of(self.scene, config.numbers, self.points)

    @cached_property
    def shelling(self) -> Shelling:
        """Made when it is used first."""
        return Shelling(self.geometry, self._config, **self._options)

    def record(self, point: int = 0, hemisphere: Hemisphere | None = None) -> FrustumRecord:
        """The hemisphere at a point, or another one."""
        return hemisphere_record(hemisphere or self._hemisphere, self.geometry.coordinates, self.points[point],
                                 self._down)

    def plan(self, clusters: int, *, ratio: int = RATIO, ray_capacity: int | None = None) -> Schedule:
        """The schedule from point 0."""
        return schedule(self.record(0), self.geometry, self.shelling.table, self._config, clusters=clusters,
                        ratio=ratio, ray_capacity=ray_capacity)

    def references(self, point: int) -> np.ndarray:
        """Tests of each patch in a casting."""
        frequency = np.zeros(len(self.geometry), dtype=np.int64)
        self.shelling.cast(self.record(point), references=frequency)
        return frequency
