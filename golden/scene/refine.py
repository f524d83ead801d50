"""Patches cut into elements, for radiosities that change over a patch."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import InputError
from golden.scene.cuts import Cuts
from golden.scene.scene import Scene

__all__ = ["MOST_ELEMENTS", "Refinement", "refine"]

MOST_ELEMENTS = 1 << 21
"""Most elements of a refinement."""

SLACK = 1e-12
"""Relative excess over a bound that counts as rounding: 1 / 0.1 pieces are 10."""

HALVINGS = 60


@dataclass(frozen=True, kw_only=True, eq=False)
class Refinement:
    """A scene and its elements.

    Parameters
    ----------
    scene
        The scene whose patches are the elements; ``surface``, ``smooth`` and all else are the patch's. Neighbours
        with the same cuts of their common edge share the cut points bit for bit.
    parent
        E int64, the patch of each element.
    first
        N int64: the first element of each patch; the others follow.
    cuts
        Elements of a quad along u and v; twice n for a triangle of n x n elements.
    is_triangle
        N bool, of the patches.
    """

    scene: Scene
    parent: np.ndarray
    first: np.ndarray
    cuts: Cuts
    is_triangle: np.ndarray

    def locate(self, patch: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The elements at bilinear coordinates (u, v) in [0, 1] of patches: R int64 from three arrays of R.

        In a quad element ``first + iv nu + iu``; in a triangle rows along v, in each row upright and inverted elements
        alternate (a triangle is a quad with V3 = V2: its barycentric coordinates are b1 = u (1 - v) and b2 = v).
        """
        # Of one type, as each is compiled for.
        patch, u, v = np.asarray(patch, dtype=np.int64), np.asarray(u), np.asarray(v)
        in_triangle = self.is_triangle[patch]
        along = self.cuts.cells(patch, 0, np.where(in_triangle, u * (1 - v), u))
        up = self.cuts.cells(patch, 1, v)
        element = np.empty(len(patch), dtype=np.int64)
        _locate(patch, along, up, self.cuts.counts, self.is_triangle, self.first, element)
        return element


@compiled
def _locate(patch, along, up, cuts, is_triangle, first, element):
    for k in range(len(patch)):
        own = patch[k]
        columns, rows = cuts[own]
        row = min(max(int(np.floor(up[k])), 0), rows - 1)
        if is_triangle[own]:
            last = columns - 1 - row
            column = min(max(int(np.floor(along[k])), 0), last)
            turned = along[k] - column + up[k] - row > 1 and column < last
            element[k] = first[own] + row * (2 * columns - row) + 2 * column + (1 if turned else 0)
        else:
            element[k] = first[own] + row * columns + min(max(int(np.floor(along[k])), 0), columns - 1)


def _pieces(length: np.ndarray, side: np.ndarray) -> np.ndarray:
    return np.maximum(1, np.ceil(length / side * (1 - SLACK)))


def _largest_cell(vertices: np.ndarray, cuts: np.ndarray) -> np.ndarray:
    """Area of the largest cell of quads cut ``cuts[:, 0]`` x ``cuts[:, 1]`` times.

    A cell's area is the Jacobian in its middle times its size in (u, v); the Jacobian is linear, so the largest cell is
    at a corner.
    """
    a, b, c, d = np.swapaxes(vertices, 0, 1)
    jacobians = []
    for u in (0.5 / cuts[:, :1], 1 - 0.5 / cuts[:, :1]):
        for v in (0.5 / cuts[:, 1:], 1 - 0.5 / cuts[:, 1:]):
            along, up = (1 - v) * (b - a) + v * (c - d), (1 - u) * (d - a) + u * (c - b)
            jacobians.append(np.linalg.norm(np.cross(along, up), axis=1))
    return np.max(jacobians, axis=0) / cuts.prod(axis=1)


def _quad_cuts(vertices: np.ndarray, max_edge: float, max_area: float) -> np.ndarray:
    """Cuts into cells no longer than ``max_edge`` and no larger than ``max_area``, as square as possible."""
    edges = np.linalg.norm(np.roll(vertices, -1, axis=1) - vertices, axis=2)
    lengths = np.stack((np.maximum(edges[:, 0], edges[:, 2]), np.maximum(edges[:, 1], edges[:, 3])), axis=1)
    high = np.minimum(lengths.max(axis=1), max_edge)
    cuts = _pieces(lengths, high[:, None])
    large = np.flatnonzero(_largest_cell(vertices, cuts) > max_area * (1 + 1e3 * SLACK))
    if not len(large):
        return cuts
    vertices, lengths, high = vertices[large], lengths[large], high[large]
    low = np.minimum(high, np.sqrt(max_area) / 4)
    while (failing := _largest_cell(vertices, _pieces(lengths, low[:, None])) > max_area).any():
        low = np.where(failing, low / 2, low)
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        fits = _largest_cell(vertices, _pieces(lengths, middle[:, None])) <= max_area * (1 + 1e3 * SLACK)
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    cuts[large] = _pieces(lengths, low[:, None])
    return cuts


def _triangle_cuts(vertices: np.ndarray, max_edge: float, max_area: float) -> np.ndarray:
    corners = vertices[:, :3]
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    count = np.maximum(_pieces(longest, max_edge), _pieces(np.sqrt(area), np.sqrt(max_area)))
    return np.repeat(count[:, None], 2, axis=1)


def _uniform(count: int) -> np.ndarray:
    """2 x (count + 1): places of cuts, and what they leave."""
    # On an edge two of the four weights are zero and the other two are k/n and (n - k)/n from either side: neighbours
    # get the same bits.
    step = np.arange(count + 1)
    return np.stack([step, count - step]) / count


def _quad_elements(vertices: np.ndarray, along: np.ndarray, up: np.ndarray) -> np.ndarray:
    """P x (nv nu) x 4 x 3 cells of P quads; ``along`` and ``up`` as `_uniform` returns them."""
    (right, upper), (left, lower) = np.meshgrid(along[0], up[0]), np.meshgrid(along[1], up[1])
    a, b, c, d = (vertices[:, None, None, k] for k in range(4))
    points = (((left * lower)[..., None] * a + (right * lower)[..., None] * b)
              + ((right * upper)[..., None] * c + (left * upper)[..., None] * d))
    cells = np.stack((points[:, :-1, :-1], points[:, :-1, 1:], points[:, 1:, 1:], points[:, 1:, :-1]), axis=3)
    return cells.reshape(len(vertices), -1, 4, 3)


def _triangle_elements(vertices: np.ndarray, n: int) -> np.ndarray:
    """P x (n n) x 4 x 3 congruent elements of P triangles."""
    rows = np.concatenate([np.full(2 * (n - row) - 1, row) for row in range(n)])
    columns = np.concatenate([np.arange(2 * (n - row) - 1) for row in range(n)])
    turned, column = columns % 2 == 1, columns // 2
    one = np.stack((np.where(turned, column + 1, column), rows), axis=1)
    two = np.stack((column + 1, np.where(turned, rows + 1, rows)), axis=1)
    three = np.stack((column, rows + 1), axis=1)
    steps = np.stack((one, two, three, three), axis=1)
    second, third, first = steps[..., 0], steps[..., 1], n - steps.sum(axis=-1)
    a, b, c = (vertices[:, None, None, k] for k in range(3))
    return ((first / n)[..., None] * a + (second / n)[..., None] * b) + (third / n)[..., None] * c


def refine(scene: Scene, *, max_edge: float | None = None, max_area: float | None = None,
           finer: Callable[[Cuts], dict[int, tuple[np.ndarray, np.ndarray]]] | None = None) -> Refinement:
    """Cuts every patch into as few elements within the bounds as possible.

    Quads are cut uniformly in their bilinear coordinates, nu x nv, unless they have knots, triangles into n x n
    congruent ones. Within an area bound the cells of a quad are as square as possible.

    Parameters
    ----------
    max_edge
        Bound of the edges of elements, in scene units.
    max_area
        Bound of the areas of elements, in squared scene units.
    finer
        Gives, for the uniform cuts, the knots of the quads that are cut otherwise, as `Cuts` takes them. Default: none.

    Raises
    ------
    InputError
        A bound is not a finite value above 0, or requires more than `MOST_ELEMENTS`.
    """
    for name, bound in (("edge", max_edge), ("area", max_area)):
        if bound is not None and not (np.isfinite(bound) and bound > 0):
            raise InputError(f"refinement: Max {name} must be a finite value above 0, not {bound!r}")
    bounds = (np.inf if max_edge is None else max_edge, np.inf if max_area is None else max_area)
    # A patch needs at least its area over that of the largest element; this bounds the count before the cuts.
    with np.errstate(divide="ignore", over="ignore"):
        least = (scene.areas / min(bounds[0] ** 2, bounds[1])).sum()
    is_triangle = scene.is_triangle
    cuts = np.ones((len(scene), 2))
    if least <= 2 * MOST_ELEMENTS:
        cuts[~is_triangle] = _quad_cuts(scene.vertices[~is_triangle], *bounds)
        cuts[is_triangle] = _triangle_cuts(scene.vertices[is_triangle], *bounds)
    total = max(least, cuts.prod(axis=1).sum())
    if total > MOST_ELEMENTS:
        raise InputError(f"refinement: it would take {total:.3g} elements or more, at most {MOST_ELEMENTS} are allowed")
    cuts = cuts.astype(np.int64)
    knots = finer(Cuts(cuts)) if finer else {}
    for patch, own in knots.items():
        cuts[patch] = [len(places) - 1 for places in own]
    counts = cuts.prod(axis=1)
    first = np.cumsum(counts) - counts
    parent = np.repeat(np.arange(len(scene)), counts)
    vertices = np.empty((len(parent), 4, 3))
    kinds, kind = np.unique(np.column_stack((cuts, is_triangle)), axis=0, return_inverse=True)
    for number, (nu, nv, triangular) in enumerate(kinds.tolist()):
        chosen = np.flatnonzero(kind.reshape(-1) == number)
        pieces = (_triangle_elements(scene.vertices[chosen], nu) if triangular else
                  _quad_elements(scene.vertices[chosen], _uniform(nu), _uniform(nv)))
        vertices[first[chosen, None] + np.arange(nu * nv)] = pieces
    for patch, own in knots.items():
        pieces = _quad_elements(scene.vertices[[patch]], *(np.stack([places, 1 - places]) for places in own))
        vertices[first[patch]:first[patch] + counts[patch]] = pieces[0]
    return Refinement(scene=scene.with_parts(parent, vertices), parent=parent, first=first, cuts=Cuts(cuts, knots),
                      is_triangle=is_triangle)
