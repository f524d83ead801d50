"""Fronts of sides that coincide with the back of a one-sided patch."""

from itertools import pairwise

import numpy as np

from golden.light.factors.certain import TOUCH
from golden.light.factors.sides import Sides

__all__ = ["CoincidentFronts"]

# Largest difference of 1 and the cosine between a normal and the opposite of another one, for parallel planes.
_PARALLEL = 2.0**-40


class CoincidentFronts:
    """What rays meet where patches lie back to back.

    Two one-sided patches in one plane with opposite fronts make a thin wall. Both are at the same distance from a ray's
    origin, and a caster names either. The ray meets the one whose front faces it.
    """

    def __init__(self, sides: Sides):
        self._sides = sides
        height = np.einsum("ni,ni->n", sides.normal, sides.centre)
        self._order = np.argsort(height, kind="stable")
        self._height = height[self._order]
        self._touch = TOUCH * sides.scene.size

    def met(self, patch: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """The sides that rays meet which hit the backs of one-sided patches.

        Parameters
        ----------
        patch
            R int: the patches that are hit.
        origin, direction
            R x 3 float64, of the rays.

        Returns
        -------
        R int64: the side whose front is there too, the first of several, or -1.
        """
        sides, found = self._sides, np.full(len(patch), -1)
        rays = np.argsort(patch, kind="stable")
        first = np.flatnonzero(np.diff(patch[rays], prepend=-1))
        for begin, end in pairwise([*first, len(rays)]):
            hit, group = patch[rays[begin]], rays[begin:end]
            normal, centre = sides.normal[hit], sides.centre[hit]
            height = -(normal @ centre)
            low, high = np.searchsorted(self._height, [height - self._touch, height + self._touch])
            near = np.sort(self._order[low:high])
            near = near[sides.normal[near] @ normal <= _PARALLEL - 1]
            if not len(near):
                continue
            distance = (centre - origin[group]) @ normal / (direction[group] @ normal)
            inside = self._contain(near, origin[group] + distance[:, None] * direction[group])
            found[group] = np.where(inside.any(axis=1), near[inside.argmax(axis=1)], -1)
        return found

    def _contain(self, sides, points):
        """Whether points in the plane of sides are in each: points x sides bool."""
        corners, normal = self._sides.vertices[sides], self._sides.normal[sides]
        along = np.roll(corners, -1, axis=1) - corners
        inwards = np.cross(normal[:, None], along)
        rise = np.einsum("nki,pnki->pnk", inwards, points[:, None, None] - corners)
        return (rise >= -self._touch * np.linalg.norm(along, axis=2)).all(axis=2)
