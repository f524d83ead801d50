"""Lattices of nodes: the points of a scene's surfaces between which light is interpolated."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from golden.base.compiled import compiled
from golden.light.surface_points import SurfacePoints, bilinear, corner_normals
from golden.scene.cuts import Cuts
from golden.scene.scene import Scene

__all__ = ["Lattice", "LatticePosition"]

# A node on the rim of a patch moves by this share of its distance to the patch's centre, out of the corner that it
# shares with the next surface, which it would see edge-on.
INSET = 1e-3
# But by at least about this share of the scene's size, or half of the distance: the machine's integers do not resolve
# the next surface from nearer to it.
CLEAR = 2.0**-19
# A node of a curved surface rises by this share of its patch's size above it, free of its neighbours' facets.
LIFT = 2e-3
# Positions nearer than this share of the scene's size are one node.
SAME = 1e-6
# Offset of the borders of that rounding, so that no round coordinate is on one.
ASIDE = 0.381966
# Sheets of a surface that folds back on itself do not share nodes: the mean of their normals is shorter than this.
FOLDED = 1e-6


@dataclass(frozen=True, eq=False)
class LatticePosition:
    """Positions of K points in a lattice.

    Parameters
    ----------
    cell
        K int: the number of the cell.
    a, b
        K float64 each, 0 to 1: position in the cell.
    nodes, weights
        K x 4: the nodes around the point and their shares in the interpolated value, which sum to 1: bilinear in a
        quadrilateral's cell, linear in either half of a triangle's.
    """

    cell: np.ndarray
    a: np.ndarray
    b: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray

    def __getitem__(self, rows) -> "LatticePosition":
        return LatticePosition(self.cell[rows], self.a[rows], self.b[rows], self.nodes[rows], self.weights[rows])


class Lattice:
    """Sheets, each a rectangle of a patch's (u, v) on one of its sides, cut into cells with nodes at their corners.

    Sheets of one smooth surface share the nodes where their cells' corners meet, so what is interpolated from nodes has
    no edges inside a surface.

    Parameters
    ----------
    patch, side
        S each: the patch of each sheet, and 1 for its front or -1 for its back.
    cuts
        S x 2: cells along u and along v. On a triangle both are n, and the cells are those of the triangle's edges from
        vertex 0, of which the ones beyond the third edge stay unused.
    lower, upper
        S x 2: the rectangle. Triangles take (0, 0) to (1, 1) only.
    knots
        Where the patches are cut, if the sheets are whole patches: ``cuts`` are its counts. Default: uniformly.

    Members
    -------
    position, normal
        M x 3 each: position of each node, and its unit normal on the sheet's side.
    source
        M int: the surface of each node.
    points
        The nodes as points of patches.
    """

    def __init__(self, scene: Scene, *, patch, side, cuts, lower, upper, knots: Cuts | None = None):
        self._cuts, self._triangle = cuts, scene.is_triangle[patch]
        self._patch, self._side, self._knots = patch, side, knots
        self._first_cell = np.cumsum(cuts.prod(axis=1)) - cuts.prod(axis=1)
        sheet, x, y = _points(self._triangle, cuts)
        x, y = (self._places(sheet, axis, places) for axis, places in ((0, x), (1, y)))
        count = np.bincount(sheet, minlength=len(cuts))
        self._first = np.cumsum(count) - count
        u, v = (lower[sheet] + np.stack([x, y], axis=1) * (upper - lower)[sheet]).T
        patch, side = patch[sheet], side[sheet]
        position = bilinear(scene.vertices[patch], u, v)
        keys = np.column_stack([np.rint(position / (SAME * scene.size) + ASIDE), scene.smooth[patch], side])
        normal = bilinear(corner_normals(scene)[patch], u, v) * side[:, None]
        _, one, self._node = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        folded = np.linalg.norm(self._mean(normal), axis=1)[self._node] < FOLDED
        if folded.any():
            keys = np.column_stack([keys, np.where(folded, sheet, -1)])
            _, one, self._node = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        self.normal = self._mean(normal)
        self.normal /= np.linalg.norm(self.normal, axis=1, keepdims=True)
        middle = bilinear(scene.vertices[patch], *np.full((2, len(patch)), 0.5))
        inset = _inset(scene)[patch, None] * (middle - position)
        lift = LIFT * np.sqrt(scene.areas[patch]) * scene.is_curved[patch]
        self.position = self._mean(position + inset) + self._mean(lift[:, None]) * self.normal
        self.source = scene.surface[patch[one]]
        self.points = SurfacePoints(self.position, self.normal, patch[one])

    def __len__(self) -> int:
        return len(self.position)

    @property
    def nodes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, normal and source."""
        return self.position, self.normal, self.source

    @property
    def cells(self) -> int:
        """Number of cells, including the unused ones of triangles."""
        return int(self._cuts.prod(axis=1).sum())

    def at(self, sheet: np.ndarray, x: np.ndarray, y: np.ndarray) -> LatticePosition:
        """The positions at (x, y) of sheets, 0 to 1 over a sheet's rectangle; on a triangle these are its u and v."""
        x = self._cells(sheet, 0, np.where(self._triangle[sheet], x * (1 - y), x))
        y = self._cells(sheet, 1, y)
        count = len(sheet)
        cell, nodes = np.empty(count, dtype=np.int64), np.empty((count, 4), dtype=np.int64)
        (a, b), weights = np.empty((2, count)), np.empty((count, 4))
        _positions(sheet, x, y, self._cuts, self._triangle, self._first_cell, self._first, self._node, cell, a, b,
                   nodes, weights)
        return LatticePosition(cell, a, b, nodes, weights)

    def inner_points(self, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, LatticePosition]:
        """``count`` x ``count`` points inside every used cell, evenly spaced; the sheets must be whole patches.

        Returns
        -------
        Patch, side, u, v and position of each point.
        """
        sheet, i, j = self._used
        row, column = (grid.ravel() for grid in np.meshgrid(*[(np.arange(count) + 0.5) / count] * 2, indexing="ij"))
        i, j = (i[:, None] + column).ravel(), (j[:, None] + row).ravel()
        sheet = np.repeat(sheet, count**2)
        inside = ~self._triangle[sheet] | (i + j < self._cuts[sheet, 0])
        sheet, i, j = (values[inside] for values in (sheet, i, j))
        u, v = self._coordinates(sheet, i, j)
        return self._patch[sheet], self._side[sheet], u, v, self.at(sheet, u, v)

    def beside(self, cell: np.ndarray, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """The cells so many columns and rows from K cells, or -1 beyond the edges of their sheets."""
        sheet = np.searchsorted(self._first_cell, cell, side="right") - 1
        (n, m), first = self._cuts[sheet].T, self._first_cell[sheet]
        j, i = np.divmod(cell - first, n)
        i, j = i + columns, j + rows
        return np.where((i >= 0) & (i < n) & (j >= 0) & (j < m), first + j * n + i, -1)

    @cached_property
    def neighbours(self) -> sparse.csr_array:
        """M x M: number of cells of which two nodes are corners."""
        sheet, i, j = self._used
        share = np.where(self._triangle[sheet], 1 / 3, 0.5)
        position = self.at(sheet, *self._coordinates(sheet, i + share, j + share))
        rows = np.repeat(np.arange(len(sheet)), 4)
        corners = sparse.csr_array(((position.weights > 0).ravel().astype(np.float64), (rows, position.nodes.ravel())),
                                   shape=(len(sheet), len(self)))
        return (corners.T @ corners).tocsr()

    @property
    def _used(self):
        """Sheet, column and row of each cell that is not beyond the third edge of a triangle."""
        sheet = np.repeat(np.arange(len(self._cuts)), self._cuts.prod(axis=1))
        j, i = np.divmod(np.arange(len(sheet)) - self._first_cell[sheet], self._cuts[sheet, 0])
        used = ~self._triangle[sheet] | (i + j < self._cuts[sheet, 0])
        return sheet[used], i[used], j[used]

    def _coordinates(self, sheet, i, j):
        """Bilinear coordinates, u and v, of points that are given in cells."""
        x, y = (self._places(sheet, axis, cell / self._cuts[sheet, axis]) for axis, cell in enumerate((i, j)))
        return np.where(self._triangle[sheet], x / (1 - y), x), y

    def _cells(self, sheet, axis, places):
        """Places from 0 to 1 along an axis of sheets, in cells."""
        if self._knots is None:
            return places * self._cuts[sheet, axis]
        return self._knots.cells(self._patch[sheet], axis, places)

    def _places(self, sheet, axis, places):
        """Places from 0 to 1 among evenly spaced cells as those among the sheets' cells."""
        some = np.flatnonzero(self._knots.has_knots(self._patch[sheet])) if self._knots else ()
        if len(some):
            places = places.copy()
            sheet = sheet[some]
            places[some] = self._knots.places(self._patch[sheet], axis, places[some] * self._cuts[sheet, axis])
        return places

    def _mean(self, values):
        """Mean over the sheets' own corners that are one node."""
        total = np.stack([np.bincount(self._node, column) for column in values.T], axis=1)
        return total / np.bincount(self._node)[:, None]


@compiled
def _positions(sheet, x, y, cuts, is_triangle, first_cell, first, node_of, cell, a_of, b_of, nodes, weights):
    """Writes positions of points, given in cells; entries of ``node_of`` from ``first`` on are a sheet's nodes."""
    for k in range(len(sheet)):
        own = sheet[k]
        (n, m), triangle = cuts[own], is_triangle[own]
        i = min(max(int(x[k]), 0), n - 1)
        j = min(max(int(y[k]), 0), m - 1 - i if triangle else m - 1)
        a, b = min(max(x[k] - i, 0.0), 1.0), min(max(y[k] - j, 0.0), 1.0)
        base, row, beyond = i + j * (n + 1), n + 1, 1
        far = triangle and a + b > 1 and i + j < n - 1
        if triangle:
            base, row = base - j * (j - 1) // 2, row - j
            if not far:
                # Rounding may leave a triangle over its third edge.
                over = max(a + b, 1.0)
                a, b, beyond = a / over, b / over, 0
        if far:
            shares = 0.0, 1 - b, 1 - a, a + b - 1
        elif triangle:
            shares = 1 - a - b, a, b, 0.0
        else:
            shares = (1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b
        cell[k], a_of[k], b_of[k] = first_cell[own] + j * n + i, a, b
        start = first[own] + base
        for corner, entry in enumerate((start, start + 1, start + row, start + row + beyond)):
            nodes[k, corner], weights[k, corner] = node_of[entry], shares[corner]


def _inset(scene):
    """N float64: by which share of its distance to its patch's centre a node moves."""
    longest = np.linalg.norm(scene.vertices - np.roll(scene.vertices, 1, axis=1), axis=2).max(axis=1)
    return np.clip(2 * CLEAR * scene.size * longest / scene.areas, INSET, 0.5)


def _points(triangle, cuts):
    """Sheet and (x, y) of every lattice point: rows of constant y, the one from vertex 0 to vertex 1 first."""
    rows = np.repeat(np.arange(len(cuts)), cuts[:, 1] + 1)
    j = np.arange(len(rows)) - np.repeat(np.cumsum(cuts[:, 1] + 1) - cuts[:, 1] - 1, cuts[:, 1] + 1)
    length = cuts[rows, 0] + 1 - np.where(triangle[rows], j, 0)
    sheet, j = np.repeat(rows, length), np.repeat(j, length)
    i = np.arange(len(sheet)) - np.repeat(np.cumsum(length) - length, length)
    # A triangle's rows shrink; its last one is a point, at which any x will do.
    x = i / np.maximum(cuts[sheet, 0] - np.where(triangle[sheet], j, 0), 1)
    return sheet, x, j / cuts[sheet, 1]
