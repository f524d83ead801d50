"""Points in space at which illuminance is measured."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, is_whole
from golden.cast.casters import CastsRays
from golden.cast.rays import Rays
from golden.scene.scene import Scene

__all__ = ["Sensors"]

# A sensor nearer to a surface than this share of the scene's size lies on it.
ON_SURFACE = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensors:
    """S points with the directions that they face.

    Parameters
    ----------
    position
        S x 3 float64, scene units.
    normal
        S x 3 float64, any length above 0; made unit vectors.
    plane
        S int: the work plane that the point belongs to, from 0, or -1. Default: none.

    Raises
    ------
    InputError
        Shapes do not match, a value is not finite, a normal is zero, or there is no point.
    """

    position: np.ndarray
    normal: np.ndarray
    plane: np.ndarray | None = None

    def __post_init__(self):
        position, normal = (np.array(value, dtype=np.float64) for value in (self.position, self.normal))
        if position.ndim != 2 or position.shape[1] != 3 or position.shape != normal.shape or not len(position):
            raise InputError(f"sensors: Position and normal must be S x 3 each, not {position.shape!r} and "
                             f"{normal.shape!r}", parameter="position")
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        bad = np.flatnonzero(~(np.isfinite(position).all(axis=1) & np.isfinite(length[:, 0]) & (length[:, 0] > 0)))
        if len(bad):
            raise InputError(f"sensors: Sensor {bad[0]} must have a finite position and direction other than zero, not "
                             f"{position[bad[0]].tolist()} and {normal[bad[0]].tolist()}",
                             parameter="position")
        plane = np.full(len(position), -1) if self.plane is None else np.asarray(self.plane, dtype=np.int64)
        if plane.shape != length[:, 0].shape:
            raise InputError(f"sensors: Plane must be {len(position)} numbers, not {plane.shape!r}", parameter="plane")
        for name, value in (("position", position), ("normal", normal / length), ("plane", plane)):
            object.__setattr__(self, name, value)

    @classmethod
    def on_plane(cls, corner, along, across, steps: tuple[int, int]) -> "Sensors":
        """The centres of the fields of a work plane, facing ``along`` x ``across``; along it they run fastest.

        Parameters
        ----------
        corner, along, across
            A corner of the plane, and its edges from there.
        steps
            Fields along both edges, at least 1.

        Raises
        ------
        InputError
            A number of steps is no whole number above 0; and as of the class.
        """
        m, n = steps
        if not all(is_whole(count) and count >= 1 for count in steps):
            raise InputError(f"sensors: Steps must be two whole numbers of at least 1, not {steps!r}",
                             parameter="steps")
        corner, along, across = (np.asarray(value, dtype=np.float64) for value in (corner, along, across))
        u, v = (np.arange(m) + 0.5) / m, (np.arange(n) + 0.5) / n
        points = corner + np.tile(u, n)[:, None] * along + np.repeat(v, m)[:, None] * across
        return cls(position=points, normal=np.tile(np.cross(along, across), (len(points), 1)),
                   plane=np.zeros(len(points)))

    def __len__(self) -> int:
        return len(self.position)

    def patches(self, scene: Scene, caster: CastsRays) -> np.ndarray:
        """S int: the patch on which each sensor lies, or -1; its surface does not shade the sensor."""
        near = ON_SURFACE * scene.size
        hits = caster.nearest(Rays(self.position + near * self.normal, -self.normal, tmax=np.full(len(self), 2 * near)))
        return hits.patch
