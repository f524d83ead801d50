"""Collects patches into a scene."""

import numpy as np

from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["SceneBuilder"]


class SceneBuilder:
    """Collects arrays of patches and assigns the numbers of materials, surfaces and smooth groups."""

    def __init__(self, name: str):
        self._name = name
        self._materials: dict[Material, int] = {}
        self._vertices: list[np.ndarray] = []
        self._columns: dict[str, list[np.ndarray]] = {key: [] for key in ("material", "surface", "smooth", "two_sided")}
        self._surfaces = 0

    def add(self, patches, material: Material, *, surface=None, smooth: bool = False, two_sided: bool = False) -> None:
        """Append patches of one material.

        Parameters
        ----------
        patches
            N x 4 x 3 (or one 4 x 3) in scene units, counter-clockwise from the front; the last vertex of a triangle is
            repeated.
        material
            Their material.
        surface
            N int, equal for patches cut from one planar polygon, or one number for all. Default: each patch is its own
            surface.
        smooth
            Whether all these patches together approximate one curved surface.
        two_sided
            Whether the backs reflect and emit like the fronts.
        """
        patches = np.asarray(patches, dtype=np.float64).reshape(-1, 4, 3)
        count = len(patches)
        surface = np.arange(count) if surface is None else np.unique(
            np.broadcast_to(surface, count), return_inverse=True)[1]
        if not count:
            return
        surface = surface + self._surfaces
        self._surfaces = int(surface.max()) + 1
        self._vertices.append(patches)
        number = self._materials.setdefault(material, len(self._materials))
        self._columns["material"].append(np.full(count, number))
        self._columns["surface"].append(surface)
        self._columns["smooth"].append(np.full(count, surface[0]) if smooth else surface)
        self._columns["two_sided"].append(np.full(count, two_sided))

    def build(self, **properties) -> Scene:
        """The scene; ``properties`` are those of `Scene` (camera, lights, background, up)."""
        vertices = np.concatenate(self._vertices) if self._vertices else np.empty((0, 4, 3))
        columns = {name: np.concatenate(parts) if parts else np.empty(0) for name, parts in self._columns.items()}
        return Scene(name=self._name, vertices=vertices, materials=tuple(self._materials), **columns, **properties)
