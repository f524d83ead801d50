"""Refinement: the host's choice of the patch that shoots next, and what the intensity messages add."""

import numpy as np

from golden.scene.scene import Scene

__all__ = ["Refinement"]


class Refinement:
    """Progressive refinement: the patch with most unshot light shoots it.

    Parameters
    ----------
    scene
        The scene. Where none of its patches emits, all emit alike.

    Members
    -------
    unshot
        N x 3 float64, radiosity that has not been shot.

    Source: Shen & Deprettere, section 1.3.1; Cohen et al. 1988.
    """

    def __init__(self, scene: Scene):
        self._area, self._reflectance = scene.areas, scene.channels("diffuse")
        emission = scene.channels("emission")
        self.unshot = emission if emission.any() else np.ones((len(scene), 3))

    def choose(self) -> int:
        """The patch whose unshot radiosity times its area is largest; the first one of equal ones."""
        return int((self._area * self.unshot.sum(axis=1)).argmax())

    def shoot(self, patch: int, factors: np.ndarray) -> None:
        """Shoot the light of a patch.

        Parameters
        ----------
        factors
            N float64, the form factors from ``patch`` to all patches.
        """
        arrives = factors * self._area[patch] / self._area
        amount = self.unshot[patch].copy()
        self.unshot[patch] = 0
        self.unshot += self._reflectance * arrives[:, None] * amount
