"""Scene (G) coordinates: positions in the machine's integers."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Numbers
from golden.scene.scene import Scene

__all__ = ["GCoordinates"]

# Margin on each side of the unit cube.
MARGIN = 2.0**-10


@dataclass(frozen=True, kw_only=True, eq=False)
class GCoordinates:
    """One uniform scale from scene units to unsigned 0.b fractions of the unit cube; rounded to nearest.

    The same point always gives the same integers, so patches that share a vertex share its integers.

    Parameters
    ----------
    corner
        Scene point that becomes (0, 0, 0).
    scale
        Length of the unit cube's side per scene unit.
    numbers
        Widths of the integers.
    bounds
        2 x 3, the scene box in scene units.
    """

    corner: np.ndarray
    scale: float
    numbers: Numbers
    bounds: np.ndarray

    @classmethod
    def of(cls, scene: Scene, numbers: Numbers, points=()) -> "GCoordinates":
        """The coordinates that hold the scene, its camera and ``points`` (M x 3: every origin to cast from).

        Raises
        ------
        InputError
            A point is not finite, or all vertices coincide.
        """
        points = np.concatenate([scene.bounds, np.asarray(points, dtype=np.float64).reshape(-1, 3),
                                 [scene.camera.eye] if scene.camera else np.empty((0, 3))])
        if not np.isfinite(points).all():
            raise InputError(f"scene {scene.name!r}: Origins must be finite")
        lower, upper = points.min(axis=0), points.max(axis=0)
        side = (upper - lower).max()
        if not side > 0:
            raise InputError(f"scene {scene.name!r}: its vertices are all at one point")
        scale = (1 - 2 * MARGIN) / side
        return cls(corner=lower - MARGIN / scale, scale=scale, numbers=numbers, bounds=scene.bounds)

    def integers(self, points) -> np.ndarray:
        """G coordinates of ... x 3 scene points: ... x 3 int64.

        Raises
        ------
        InputError
            A point is outside the cube.
        """
        points = np.asarray(points, dtype=np.float64)
        scaled = np.floor((points - self.corner) * (self.scale * 2.0**self.numbers.scene_bits) + 0.5)
        bad = ~((scaled >= 0) & (scaled <= self.numbers.scene.high)).all(axis=-1)
        if bad.any():
            raise InputError(f"Point must be within the scene's coordinates, not {points[bad][0].tolist()!r}")
        return scaled.astype(np.int64)

    def points(self, integers) -> np.ndarray:
        """The scene points of ... x 3 integers: float64, scene units."""
        return self.numbers.scene.decode(integers) / self.scale + self.corner

    def cell_size(self, fraction: float) -> int:
        """The side of a cell of ``fraction`` of the scene box's longest side, rounded up."""
        longest = (self.bounds[1] - self.bounds[0]).max()
        return int(np.ceil(fraction * longest * self.scale * 2.0**self.numbers.scene_bits))
