"""Patch geometry: a scene's patches in the machine's integers."""

from dataclasses import dataclass

import numpy as np

from golden.engine.config import Numbers
from golden.engine.scene.g_coordinates import GCoordinates
from golden.scene.scene import Scene

__all__ = ["PatchGeometry"]


@dataclass(frozen=True, kw_only=True, eq=False)
class PatchGeometry:
    """N patches; a triangle repeats its last vertex.

    Parameters
    ----------
    coordinates
        Map from scene units to integers.
    vertices
        N x 4 x 3 int64, G coordinates.
    surface
        N int32, see `Scene.surface`.
    """

    coordinates: GCoordinates
    vertices: np.ndarray
    surface: np.ndarray

    @classmethod
    def of(cls, scene: Scene, numbers: Numbers, points=()) -> "PatchGeometry":
        """The patches of a scene in coordinates that also hold its camera and ``points``.

        Raises
        ------
        InputError
            See `GCoordinates.of`.
        """
        coordinates = GCoordinates.of(scene, numbers, points)
        return cls(coordinates=coordinates, vertices=coordinates.integers(scene.vertices), surface=scene.surface)

    def __len__(self) -> int:
        return len(self.vertices)

    def __getitem__(self, rows) -> "PatchGeometry":
        return PatchGeometry(coordinates=self.coordinates, vertices=self.vertices[rows], surface=self.surface[rows])
