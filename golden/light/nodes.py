"""Nodes: the points of a refined scene's surfaces between which light is interpolated."""

import numpy as np
from scipy import sparse

from golden.light.surface_points import bilinear, corner_normals
from golden.scene.refine import Refinement
from golden.scene.scene import Scene

__all__ = ["Nodes"]

# A node on the rim of a patch moves this share of the way to the patch's centre, out of the corner that it shares with
# the next surface, which would else be seen edge-on.
INSET = 1e-3
# A node of a curved surface rises by this share of its patch's size above it, free of its neighbours' facets.
LIFT = 2e-3
# Positions nearer than this share of the scene's size are one node.
SAME = 1e-6


class Nodes:
    """The corners of all elements, on both sides of two-sided patches.

    Elements of one smooth surface share the nodes between them, so what is interpolated from nodes has no edges inside
    a surface.

    Parameters
    ----------
    scene
        The patches.
    refinement
        Their elements.

    Members
    -------
    position, normal
        M x 3: where each node stands and its unit normal.
    source
        M: the surface that it lies on.
    of_elements
        Sparse, C x M: the mean over an element's corners. The C rows are the fronts of all elements, then the backs
        of the elements of two-sided patches.
    elements, sides
        C: the element of each of these rows, and 1 for its front or -1 for its back.
    back
        For each element the row of its back, or -1.
    """

    def __init__(self, scene: Scene, refinement: Refinement):
        self._scene, self._cuts = scene, refinement.cuts
        backs = np.flatnonzero(scene.two_sided)
        patch, u, v = _lattice(scene.is_triangle, self._cuts)
        count = np.bincount(patch, minlength=len(scene))
        first = np.cumsum(count) - count
        # Entries are lattice points of a side of a patch; several entries are one node.
        again = np.flatnonzero(scene.two_sided[patch])
        self._first = np.stack([first, np.full(len(scene), -1)], axis=1)
        self._first[backs, 1] = len(patch) + np.cumsum(count[backs]) - count[backs]
        side = np.repeat([1.0, -1.0], [len(patch), len(again)])
        patch, u, v = (np.concatenate([values, values[again]]) for values in (patch, u, v))
        position = bilinear(scene.vertices[patch], u, v)
        keys = np.column_stack([np.rint(position / (SAME * scene.size)), scene.smooth[patch], side])
        _, one, self._node = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        normal = bilinear(corner_normals(scene)[patch], u, v) * side[:, None]
        normal = self._mean(normal)
        self.normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        inset = INSET * (bilinear(scene.vertices[patch], *np.full((2, len(patch)), 0.5)) - position)
        lift = LIFT * np.sqrt(scene.areas[patch]) * _curved(scene)[patch]
        self.position = self._mean(position + inset) + self._mean(lift[:, None]) * self.normal
        self.source = scene.surface[patch[one]]
        count = len(refinement.parent)
        behind = np.flatnonzero(scene.two_sided[refinement.parent])
        self.back = np.full(count, -1)
        self.back[behind] = count + np.arange(len(behind))
        self.elements = np.concatenate([np.arange(count), behind])
        self.sides = np.repeat([1.0, -1.0], [count, len(behind)])
        self.of_elements = self._means(refinement)

    def __len__(self) -> int:
        return len(self.position)

    def at(self, patch: np.ndarray, u: np.ndarray, v: np.ndarray, front: np.ndarray):
        """The nodes around points of patches and their shares in the interpolated value.

        Parameters
        ----------
        patch, u, v
            K each; the side is ``front``, which must be true where the patch is not two-sided.

        Returns
        -------
        tuple
            K x 4 node numbers and K x 4 weights that sum to 1: bilinear in a quadrilateral's element, linear in a
            triangle's.
        """
        cuts_u, cuts_v = self._cuts[patch].T
        triangle = self._scene.is_triangle[patch]
        # In a triangle, along the edges from vertex 0 to vertices 1 and 2.
        x = np.where(triangle, u * (1 - v), u) * cuts_u
        y = v * cuts_v
        i = np.clip(x.astype(int), 0, cuts_u - 1)
        j = np.clip(y.astype(int), 0, np.where(triangle, cuts_v - 1 - i, cuts_v - 1))
        a, b = np.clip(x - i, 0, 1), np.clip(y - j, 0, 1)
        far = triangle & (a + b > 1) & (i + j < cuts_u - 1)
        over = np.where(triangle & ~far, np.maximum(a + b, 1), 1)
        a, b = a / over, b / over
        row = np.where(triangle, cuts_u + 1 - j, cuts_u + 1)
        base = i + j * (cuts_u + 1) - np.where(triangle, j * (j - 1) // 2, 0)
        beyond = base + row + np.where(triangle & ~far, 0, 1)
        entries = np.stack([base, base + 1, base + row, beyond], axis=1)
        square = np.stack([(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b], axis=1)
        lower = np.stack([1 - a - b, a, b, 0 * a], axis=1)
        upper = np.stack([0 * a, 1 - b, 1 - a, a + b - 1], axis=1)
        weights = np.where(triangle[:, None], np.where(far[:, None], upper, lower), square)
        first = self._first[patch, np.where(front, 0, 1)]
        return self._node[first[:, None] + entries], weights

    def _mean(self, values):
        """Mean over the entries of each node."""
        total = np.stack([np.bincount(self._node, column) for column in values.T], axis=1)
        return total / np.bincount(self._node)[:, None]

    def _means(self, refinement):
        patch, u, v = _centres(self._scene.is_triangle, self._cuts)
        at = np.argsort(refinement.locate(patch, u, v))[self.elements]
        nodes, weights = self.at(patch[at], u[at], v[at], self.sides > 0)
        rows = np.repeat(np.arange(len(at)), 4)
        return sparse.csr_array((weights.ravel(), (rows, nodes.ravel())), shape=(len(at), len(self)))


def _curved(scene):
    """N bool: whether the patch's smooth group is more than one plane."""
    group, _ = np.unique(np.stack([scene.smooth, scene.surface]), axis=1)
    return np.bincount(group, minlength=scene.smooth.max() + 1)[scene.smooth] > 1


def _lattice(triangle, cuts):
    """Patch and (u, v) of every lattice point: rows of constant v, from vertex 0 to vertex 1 first."""
    rows = np.repeat(np.arange(len(cuts)), cuts[:, 1] + 1)
    j = np.arange(len(rows)) - np.repeat(np.cumsum(cuts[:, 1] + 1) - cuts[:, 1] - 1, cuts[:, 1] + 1)
    length = cuts[rows, 0] + 1 - np.where(triangle[rows], j, 0)
    patch, j = np.repeat(rows, length), np.repeat(j, length)
    i = np.arange(len(patch)) - np.repeat(np.cumsum(length) - length, length)
    v = j / cuts[patch, 1]
    # A triangle's rows shrink; its last one is a point, at which any u will do.
    u = i / np.maximum(cuts[patch, 0] - np.where(triangle[patch], j, 0), 1)
    return patch, u, v


def _centres(triangle, cuts):
    """Patch and (u, v) of every element's centre."""
    count = cuts.prod(axis=1)
    patch = np.repeat(np.arange(len(cuts)), count)
    rank = np.arange(len(patch)) - np.repeat(np.cumsum(count) - count, count)
    j, i = np.divmod(rank, cuts[patch, 0])
    # A triangle of n x n elements is half a lattice of n x n cells; what lies beyond the diagonal folds back onto the
    # upper elements of the cells before it.
    beyond = triangle[patch] & (i + j >= cuts[patch, 0])
    n = cuts[patch, 0]
    share = np.where(triangle[patch], np.where(beyond, 2 / 3, 1 / 3), 0.5)
    i, j = np.where(beyond, n - 1 - i, i), np.where(beyond, n - 1 - j, j)
    x, y = (i + share) / n, (j + share) / cuts[patch, 1]
    return patch, np.where(triangle[patch], x / (1 - y), x), y
