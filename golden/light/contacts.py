"""Parts of surfaces beside other surfaces that touch, pierce or come close to them."""

from dataclasses import dataclass

import numpy as np

from golden.cast.rays import Rays
from golden.light.lattice import Lattice, LatticePosition
from golden.light.surface_points import bilinear
from golden.scene.scene import Scene

__all__ = ["Contacts"]

# Parts of a cell along each side. Probes start in their middles and reach as far as the next ones.
PARTS = 4
# They look along the surface, in units of the parts' steps along u and v and with this rise, and aslant.
LOW, ASLANT = 1 / 32, 1.0
PROBES = np.array([
    *((x, y, LOW) for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y),
    *((x, y, ASLANT) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)))])
# A surface that a probe meets within this share of the probe's length of the rim of a patch ends where the patch does:
# the nodes on the rim are beside it.
RIM = 1 / 16
# Corners nearer than this share of the scene's size are one.
SAME = 1e-6
# Rays per block, which bounds memory.
BLOCK = 1 << 18


class Contacts:
    """Where light cannot be interpolated from nodes, because it changes at a surface between them.

    Probes along a surface find what stands on it, aslant ones what is close above it: what they reach are contacts. In
    a cell with one, light is not interpolated close to it, nor from corners that it hides or buries. Contacts along the
    rim of a patch do not count, as its nodes are right beside them, and curved surfaces have none, as their facets are
    small.

    Parameters
    ----------
    scene, lattice
        The patches, and nodes on them; its sheets are whole patches.
    caster
        Casts the probes.
    buried
        Whether nodes are inside bodies.
    """

    def __init__(self, scene: Scene, lattice: Lattice, caster, buried: np.ndarray):
        self._scene, self._caster = scene, caster
        self._corners, self._buried = lattice.position, buried
        self._rims = _rims(scene)
        points = _Points(*lattice.inner_points(PARTS))
        points = points[~scene.is_curved[points.patch]]
        self._touched = np.zeros((lattice.cells, PARTS**2), dtype=bool)
        self._mark(points, self._are_close)
        beside = self.cells[points.position.cell] & ~self.at(points.position)
        self._mark(points[beside], self._are_hidden)

    def at(self, position: LatticePosition) -> np.ndarray:
        """K bool: whether light at K positions in the lattice is not to be interpolated."""
        return self._touched[position.cell, _part(position)]

    @property
    def cells(self) -> np.ndarray:
        """For each cell of the lattice whether a contact is in it or close to it."""
        return self._touched.any(axis=1)

    def _mark(self, points, condition):
        for start in range(0, len(points), BLOCK // len(PROBES)):
            some = points[start:start + BLOCK // len(PROBES)]
            self._touched[some.position.cell, _part(some.position)] = condition(some)

    def _are_close(self, points):
        """Which of P points have a contact within their steps."""
        corners = self._corners[points.position.nodes]
        along, up = (corners[:, [1, 2]] - corners[:, :1]).swapaxes(0, 1) / PARTS
        flat = PROBES[:, 0, None] * along[:, None] + PROBES[:, 1, None] * up[:, None]
        length = np.linalg.norm(flat, axis=2)
        normal = points.side[:, None] * self._scene.normals[points.patch]
        direction = flat + (PROBES[:, 2] * length)[:, :, None] * normal[:, None]
        origin = bilinear(self._scene.vertices[points.patch], points.u, points.v)
        point = np.repeat(np.arange(len(points)), len(PROBES))
        met, place = self._met(points.patch[point], origin[point], direction.reshape(-1, 3))
        point = point[met]
        at_rim = self._is_at_rim(points.patch[point], place, RIM * length.reshape(-1)[met])
        close = np.zeros(len(points), dtype=bool)
        close[point[~at_rim]] = True
        return close

    def _are_hidden(self, points):
        """Which of P points do not see all corners of their cells, or have buried ones."""
        nodes = points.position.nodes
        hidden = self._buried[nodes].any(axis=1)
        open_ = np.repeat(np.flatnonzero(~hidden), 4)
        normal = points.side[open_, None] * self._scene.normals[points.patch[open_]]
        origin = bilinear(self._scene.vertices[points.patch[open_]], points.u[open_], points.v[open_])
        toward = (1 - RIM) * (self._corners[nodes[~hidden]].reshape(-1, 3) - origin)
        lift = LOW / PARTS * np.linalg.norm(toward, axis=1, keepdims=True) * normal
        met, _ = self._met(points.patch[open_], origin + lift, toward)
        hidden[open_[met]] = True
        return hidden

    def _met(self, patch, origin, direction):
        """Those of rays from patches that meet another smooth surface within their lengths, and where."""
        rays = Rays(origin, direction, self._scene.surface[patch], np.ones(len(patch)))
        hits = self._caster.nearest(rays)
        met = np.flatnonzero(hits.patch >= 0)
        met = met[self._scene.smooth[hits.patch[met]] != self._scene.smooth[patch[met]]]
        return met, origin[met] + hits.t[met, None] * direction[met]

    def _is_at_rim(self, patch, place, reach):
        """Which of K places are beyond a rim of a patch, or within reach of it."""
        corners = self._scene.vertices[patch]
        edges = np.roll(corners, -1, axis=1) - corners
        inward = np.cross(self._scene.normals[patch][:, None], edges)
        distance = np.einsum("kex,kex->ke", inward, place[:, None] - corners)
        return (self._rims[patch] & (distance < reach[:, None] * np.linalg.norm(inward, axis=2))).any(axis=1)


@dataclass(frozen=True, eq=False)
class _Points:
    """P points in the middles of the parts of cells."""

    patch: np.ndarray
    side: np.ndarray
    u: np.ndarray
    v: np.ndarray
    position: LatticePosition

    def __len__(self):
        return len(self.patch)

    def __getitem__(self, rows):
        return _Points(self.patch[rows], self.side[rows], self.u[rows], self.v[rows], self.position[rows])


def _part(position):
    """The number of the part of its cell in which each position is."""
    column, row = (np.minimum((place * PARTS).astype(np.int64), PARTS - 1) for place in (position.a, position.b))
    return row * PARTS + column


def _rims(scene):
    """N x 4 bool: the edges of patches that end their smooth surfaces."""
    ends = np.rint(scene.vertices / (SAME * scene.size)).astype(np.int64)
    first, second = ends.reshape(-1, 3), np.roll(ends, -1, axis=1).reshape(-1, 3)
    _, corner = np.unique(np.concatenate([first, second]), axis=0, return_inverse=True)
    pair = np.sort(corner.reshape(2, -1), axis=0)
    _, edge, count = np.unique(np.stack([*pair, np.repeat(scene.smooth, 4)]), axis=1, return_inverse=True,
                               return_counts=True)
    # A repeated corner makes no edge.
    return ((count[edge.reshape(-1)] == 1) & (pair[0] != pair[1])).reshape(-1, 4)
