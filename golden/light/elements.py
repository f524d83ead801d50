"""The elements of a scene as the unknowns of radiosity: sides, corners and positions."""

import numpy as np
from scipy import sparse

from golden.base.compiled import compiled
from golden.cast.rays import Hits
from golden.light.lattice import Lattice, LatticePosition
from golden.scene.refine import Refinement
from golden.scene.scene import Scene

__all__ = ["Elements"]


class Elements:
    """The fronts of a refinement's elements, then the backs of those of two-sided patches: C in all.

    Members
    -------
    patch, front, vertices, centre, normal, area, triangle
        Per element: its patch (C), whether it is on its front (C), corners (C x 4 x 3), their mean (C x 3), unit normal
        on its side (C x 3), area (C), and whether it is a triangle (C).
    lattice
        Lattice of the nodes at the elements' corners; its sheets are the sides of patches.
    position
        Positions of the elements' centres in the lattice.
    of_corners
        Sparse C x M: the mean over an element's corners.
    """

    def __init__(self, scene: Scene, refinement: Refinement):
        self._scene, self._refinement = scene, refinement
        backs = np.flatnonzero(scene.two_sided)
        self._back_sheet = np.full(len(scene), -1)
        self._back_sheet[backs] = len(scene) + np.arange(len(backs))
        sheet_patch = np.concatenate([np.arange(len(scene)), backs])
        sheet_side = np.repeat([1.0, -1.0], [len(scene), len(backs)])
        self.lattice = Lattice(scene, patch=sheet_patch, side=sheet_side, cuts=refinement.cuts.counts[sheet_patch],
                               lower=np.zeros((len(sheet_patch), 2)), upper=np.ones((len(sheet_patch), 2)),
                               knots=refinement.cuts)
        count = len(refinement.parent)
        behind = np.flatnonzero(scene.two_sided[refinement.parent])
        self._back = np.full(count, -1)
        self._back[behind] = count + np.arange(len(behind))
        self._element = np.concatenate([np.arange(count), behind])
        self.front = np.arange(len(self._element)) < count
        self.patch = refinement.parent[self._element]
        self.vertices = refinement.scene.vertices[self._element]
        self.centre = refinement.scene.centres[self._element]
        self.area = refinement.scene.areas[self._element]
        self.triangle = scene.is_triangle[self.patch]
        self.normal = np.where(self.front, 1.0, -1.0)[:, None] * scene.normals[self.patch]
        patch, u, v = _centres(scene.is_triangle, refinement.cuts)
        order = np.argsort(refinement.locate(patch, u, v))[self._element]
        self.position = self.at(self.patch, u[order], v[order], self.front)
        self.of_corners = _matrix(self.position, len(self.lattice))

    def __len__(self) -> int:
        return len(self.patch)

    def at(self, patch: np.ndarray, u: np.ndarray, v: np.ndarray, front: np.ndarray) -> LatticePosition:
        """Positions of points of patches in the lattice; ``front`` must be true on a one-sided patch."""
        return self.lattice.at(np.where(front, patch, self._back_sheet[patch]), u, v)

    def number(self, patch: np.ndarray, u: np.ndarray, v: np.ndarray, front: np.ndarray) -> np.ndarray:
        """The element at points of patches, or -1 on the back of a one-sided patch."""
        element = self._refinement.locate(patch, u, v)
        return np.where(front, element, self._back[element])

    def seen(self, direction: np.ndarray, hits: Hits) -> np.ndarray:
        """The elements that rays with the directions K x 3 hit, or -1: nothing, or the back of a one-sided patch."""
        element = self._refinement.locate(np.maximum(hits.patch, 0), hits.u, hits.v)
        _choose_sides(direction, hits.patch, self._scene.normals, self._back, element)
        return element

    def refined(self, elements: np.ndarray, cuts: int) -> Lattice:
        """A lattice whose sheets are the given elements (of quadrilaterals), cut ``cuts`` times along each side."""
        patch = self.patch[elements]
        rank = self._element[elements] - self._refinement.first[patch]
        knots = self._refinement.cuts
        row, column = np.divmod(rank, knots.counts[patch, 0])
        size = 1 / knots.counts[patch]
        lower = np.stack([column, row], axis=1) * size
        upper = lower + size
        some = knots.has_knots(patch)
        for axis, cell in enumerate((column, row)):
            for end, places in enumerate((lower, upper)):
                places[some, axis] = knots.places(patch[some], axis, cell[some] + float(end))
        return Lattice(self._scene, patch=patch, side=np.where(self.front[elements], 1.0, -1.0),
                       cuts=np.full((len(elements), 2), cuts), lower=lower, upper=upper)


@compiled
def _choose_sides(direction, patch, normals, back, element):
    """Replaces elements by those of their backs where a ray hits the back."""
    for k in range(len(patch)):
        if patch[k] < 0:
            element[k] = -1
            continue
        x, y, z = normals[patch[k]]
        if not direction[k, 0] * x + direction[k, 1] * y + direction[k, 2] * z < 0:
            element[k] = back[element[k]]


def _matrix(position, nodes):
    shape = len(position.nodes), nodes
    rows = np.repeat(np.arange(len(position.nodes)), 4)
    return sparse.csr_array((position.weights.ravel(), (rows, position.nodes.ravel())), shape=shape)


def _centres(triangle, knots):
    """Patch and (u, v) of every element's centre."""
    cuts = knots.counts
    count = cuts.prod(axis=1)
    patch = np.repeat(np.arange(len(cuts)), count)
    rank = np.arange(len(patch)) - np.repeat(np.cumsum(count) - count, count)
    j, i = np.divmod(rank, cuts[patch, 0])
    # A triangle of n x n elements is half a square of n x n cells; points beyond the diagonal fold back onto the far
    # halves of the cells before it.
    n = cuts[patch, 0]
    beyond = triangle[patch] & (i + j >= n)
    share = np.where(triangle[patch], np.where(beyond, 2 / 3, 1 / 3), 0.5)
    i, j = np.where(beyond, n - 1 - i, i), np.where(beyond, n - 1 - j, j)
    x, y = (knots.places(patch, axis, cell + share) for axis, cell in enumerate((i, j)))
    return patch, np.where(triangle[patch], x / (1 - y), x), y
