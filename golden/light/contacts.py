"""Parts of surfaces beside other surfaces that touch, pierce or come close to them."""

from dataclasses import dataclass

import numpy as np

from golden.base.compiled import compiled
from golden.cast.rays import Rays
from golden.light.lattice import Lattice, LatticePosition
from golden.light.surface_points import bilinear
from golden.scene.scene import Scene

__all__ = ["PARTS", "Contacts"]

PARTS = 4
"""Parts of a cell along each side. Probes start in their middles and reach as far as the next ones."""
# They look along the surface, in units of the parts' steps along u and v and with this rise, and aslant.
LOW, ASLANT = 1 / 256, 1.0
LOW_PROBES = 8
PROBES = np.array([
    *((x, y, LOW) for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y),
    *((x, y, ASLANT) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)))])
# From a part to its neighbours.
_STEPS = PROBES[:LOW_PROBES, :2].astype(np.int64)
# Squared distances between the parts of a cell.
_APART = ((np.stack(np.divmod(np.arange(PARTS**2), PARTS))[:, :, None]
           - np.stack(np.divmod(np.arange(PARTS**2), PARTS))[:, None]) ** 2).sum(axis=0)
# A surface that a probe meets within this share of the probe's length of the rim of a patch ends where the patch does:
# the nodes on the rim are beside it.
RIM = 1 / 16
# How far parts look towards nodes: what stands on one hides it, as it sees both sides; one on a rim is farther from
# what stands there. They look along the surface, and half a part's step above it: what ends just short of the surface
# divides its light too.
PAST_NODE, RAISED = 1 + 1e-4, 0.5
# Surfaces that a probe meets are borders of light if they are inclined to the surface, at least by this sine.
STEEP = 0.3
# Corners nearer than this share of the scene's size are one.
SAME = 1e-6
# Rays per block, which bounds memory.
BLOCK = 1 << 18


class Contacts:
    """Where light cannot be interpolated from nodes, because it changes at a surface between them.

    Probes along a surface find what stands on it, aslant ones what is close above it: what they reach are contacts. In
    a cell with one, light is not interpolated close to it, nor from corners that it hides. Contacts along the rim of a
    patch do not count, as its nodes are right beside them, and curved surfaces have none, as their facets are small.

    Parameters
    ----------
    scene, lattice
        The patches, and nodes on them; its sheets are whole patches.
    caster
        Casts the probes.

    Members
    -------
    row
        For each cell of the lattice its number among the T cells with contacts, or -1.
    close
        T x `PARTS`^2 bool: which parts of these cells, in rows along v, are close to a contact.
    inside
        T x `PARTS`^2 bool: which of these have their middles in a body, but not in a thin wall, which has two
        sides in one part.
    sees
        T x `PARTS`^2 x 4 bool: the corners that each part sees, as `LatticePosition` numbers them; what is just short
        of the surface hides them as well.
    nodes
        T x 4 int: their nodes.
    """

    def __init__(self, scene: Scene, lattice: Lattice, caster):
        self._scene, self._caster = scene, caster
        self._corners, self._rims = lattice.position, _rims(scene)
        points = _Points(*lattice.inner_points(PARTS))
        points = points[~scene.is_curved[points.patch]]
        found = self._each(points, self._probed, np.zeros((len(points), 2 + 8)))
        close, inside = found[:, :2].T.astype(bool)
        cells = np.unique(points.position.cell[close])
        self.row = np.full(lattice.cells, -1)
        self.row[cells] = np.arange(len(cells))
        touched = np.flatnonzero(self.row[points.position.cell] >= 0)
        points, close, inside, borders = points[touched], close[touched], inside[touched], found[touched, 2:]
        place = self.row[points.position.cell], self.part(points.position)
        self.close = np.zeros((len(cells), PARTS**2), dtype=bool)
        self.close[place] = close
        self.inside = self.close.copy()
        self.inside[place] = inside
        self.sees = np.ones((len(cells), PARTS**2, 4), dtype=bool)
        self.sees[place] = self._each(points, self._seen_corners, np.zeros((len(points), 4), dtype=bool))
        # What is visible of a part with its middle inside a body is like the nearest part that is outside.
        hidden = self.inside & ~self.inside.all(axis=1, keepdims=True)
        nearest = np.argmin(_APART + np.where(self.inside, np.inf, 0.0)[:, None], axis=2)
        self.sees = np.take_along_axis(self.sees, np.where(hidden, nearest, np.arange(PARTS**2))[..., None], axis=1)
        self.nodes = np.zeros((len(cells), 4), dtype=np.int64)
        self.nodes[place[0]] = points.position.nodes
        self._add_borders(lattice, points, np.ravel_multi_index(place, self.close.shape), borders.reshape(-1, 2, 4))

    @staticmethod
    def part(position: LatticePosition) -> np.ndarray:
        """The number of the part of its cell in which each of K positions is."""
        column, row = (np.minimum((place * PARTS).astype(np.int64), PARTS - 1) for place in (position.a, position.b))
        return row * PARTS + column

    def places(self, position: LatticePosition) -> np.ndarray:
        """The parts with whose light K positions are, row * `PARTS`^2 + part, or -1 in cells without contacts.

        It is the one across the border if a surface that its own part meets is between its middle and the position.
        """
        result = np.full(len(position.cell), -1)
        some = np.flatnonzero(self.row[position.cell] >= 0)
        own = position[some]
        place = self.row[own.cell] * PARTS**2 + self.part(own)
        _cross(place, own.a, own.b, self._borders, self._beyond)
        result[some] = place
        return result

    def _add_borders(self, lattice, points, place, borders):
        """Keep of each part up to two lines, as coefficients of 1, a and b that are positive beyond, and what is there.

        ``borders``: P x 2 x 4 from `_probed`, unit vectors from the middles to the lines, and their lengths.
        """
        self._borders = np.zeros((self.close.size, 2, 3))
        self._beyond = np.zeros((self.close.size, 2), dtype=np.int64)
        corners = self._corners[points.position.nodes]
        edges = corners[:, [1, 2]] - corners[:, :1]
        lengths = np.linalg.norm(np.einsum("kex,se->ksx", edges, _STEPS), axis=2) / PARTS
        row, column = np.divmod(self.part(points.position), PARTS)
        for side in (0, 1):
            slope = np.einsum("kex,kx->ke", edges, borders[:, side, :3])
            # The neighbour that is most straight across.
            across = slope @ _STEPS.T / PARTS
            straight = np.where(across > borders[:, side, 3:], across / lengths, 0)
            step = _STEPS[straight.argmax(axis=1)]
            columns, to_column = np.divmod(column + step[:, 0], PARTS)
            rows, to_row = np.divmod(row + step[:, 1], PARTS)
            cell = lattice.beside(points.position.cell, columns, rows)
            found = np.flatnonzero((straight.max(axis=1) > 0) & (cell >= 0) & (self.row[cell] >= 0)
                                   & ~self._scene.is_triangle[points.patch])
            self._borders[place[found], side, 1:] = slope[found]
            middle = slope[:, 0] * points.position.a + slope[:, 1] * points.position.b
            self._borders[place[found], side, 0] = -(middle + borders[:, side, 3])[found]
            self._beyond[place[found], side] = (self.row[cell] * PARTS**2 + to_row * PARTS + to_column)[found]

    def _each(self, points, function, result):
        size = BLOCK // len(PROBES)
        for start in range(0, len(points), size):
            result[start:start + size] = function(points[start:start + size])
        return result

    def _probed(self, points):
        """P x 10: which of P points have a contact within their steps, which see it from inside a body; `_lines`."""
        corners = self._corners[points.position.nodes]
        along, up = (corners[:, [1, 2]] - corners[:, :1]).swapaxes(0, 1) / PARTS
        flat = PROBES[:, 0, None] * along[:, None] + PROBES[:, 1, None] * up[:, None]
        length = np.linalg.norm(flat, axis=2)
        normal = points.side[:, None] * self._scene.normals[points.patch]
        direction = (flat + (PROBES[:, 2] * length)[:, :, None] * normal[:, None]).reshape(-1, 3)
        origin = bilinear(self._scene.vertices[points.patch], points.u, points.v)
        point = np.repeat(np.arange(len(points)), len(PROBES))
        met, place, patch = self._met(points.patch[point], origin[point], direction)
        back = np.einsum("kx,kx->k", direction[met], self._scene.normals[patch]) > 0
        back &= ~self._scene.two_sided[patch]
        at_rim = self._is_at_rim(points.patch[point[met]], place, RIM * length.reshape(-1)[met])
        reached = np.zeros((2, len(points), len(PROBES)), dtype=bool)
        for probes, which in zip(reached, (~at_rim, back & ~at_rim), strict=True):
            probes[point[met[which]], (met % len(PROBES))[which]] = True
        close, backs = reached.sum(axis=2)
        # The probes that rise little are in an order in which the last one is opposite to the first one.
        low = reached[1, :, :LOW_PROBES]
        thin = (low & low[:, ::-1]).any(axis=1)
        kept = ~at_rim
        owner = point[met[kept]]
        lines = _lines(owner, normal, place[kept] - origin[owner], self._scene.normals[patch[kept]])
        return np.column_stack([close > 0, (backs > close / 2) & ~thin, lines])

    def _seen_corners(self, points):
        """P x 4 bool: the corners of their cells that P points see."""
        point = np.repeat(np.arange(len(points)), 4)
        normal = points.side[point, None] * self._scene.normals[points.patch[point]]
        origin = bilinear(self._scene.vertices[points.patch], points.u, points.v)[point]
        corners = self._corners[points.position.nodes]
        toward = PAST_NODE * (corners.reshape(-1, 3) - origin)
        step = np.linalg.norm(corners[:, [1, 2]] - corners[:, :1], axis=2).min(axis=1)[point] / PARTS
        seen = np.ones(len(point), dtype=bool)
        for lift in (LOW / PARTS * np.linalg.norm(toward, axis=1), RAISED * step):
            met, _, _ = self._met(points.patch[point], origin + lift[:, None] * normal, toward)
            seen[met] = False
        return seen.reshape(-1, 4)

    def _met(self, patch, origin, direction):
        """Those of rays from patches that meet another smooth surface within their lengths, where, and its patch."""
        rays = Rays(origin, direction, self._scene.surface[patch], np.ones(len(patch)))
        hits = self._caster.nearest(rays)
        met = np.flatnonzero(hits.patch >= 0)
        met = met[self._scene.smooth[hits.patch[met]] != self._scene.smooth[patch[met]]]
        return met, origin[met] + hits.t[met, None] * direction[met], hits.patch[met]

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


def _lines(point, normals, toward, across):
    """P x 8: up to two unit vectors from points along their surface to steep ones that they meet, and the distances.

    The nearest one, and the nearest one in the opposite direction: that of the other side of a wall around the point.

    Parameters
    ----------
    point, toward, across
        K each: the number of a point, the vector to what it meets, and its normal.
    normals
        P x 3: normals of the points' own surfaces.
    """
    away = across - np.einsum("kx,kx->k", across, normals[point])[:, None] * normals[point]
    sine = np.linalg.norm(away, axis=1)
    away = away / np.where(sine > 0, sine, 1)[:, None]
    distance = np.einsum("kx,kx->k", toward, away)
    away, distance = np.where(distance < 0, -1, 1)[:, None] * away, np.abs(distance)
    result = np.zeros((len(normals), 2, 4))
    left = sine > STEEP
    for side in (0, 1):
        order = np.flatnonzero(left)[np.argsort(distance[left], kind="stable")]
        owner, first = np.unique(point[order], return_index=True)
        result[owner, side] = np.column_stack([away, distance])[order[first]]
        left &= np.einsum("kx,kx->k", away, result[point, side, :3]) < 0
    return result.reshape(-1, 8)


@compiled
def _cross(place, a, b, borders, beyond):
    """Replaces the parts of positions by those beyond the borders that the positions are beyond."""
    for k in range(len(place)):
        for side in range(2):
            line = borders[place[k], side]
            if line[0] + line[1] * a[k] + line[2] * b[k] > 0:
                place[k] = beyond[place[k], side]
                break


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
