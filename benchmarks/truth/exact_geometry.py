"""Exact hits of rays on the snapped vertices, and the causes for which rounded hits may differ from them."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from benchmarks.truth.exact_patch import SCALE, ExactPatch
from benchmarks.truth.integers import dot
from benchmarks.truth.ray_tiles import RayTiles

__all__ = ["CAUSES", "ExactGeometry", "Verdict"]

CAUSES = ("tie", "depth", "edge", "unexplained")
# A product of three terms in float64 is off by less than this share of their magnitudes, rounded operands included.
FLOAT = 2.0**-50
# Bits of the planes that reject tiles, and what is lost of n . d by them.
TILE_BITS, TILE_LOSS = 35, 3 << 16
# Fraction bits and bias of a stored 1/t.
STORED, BIAS = 18, 39


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Rays of one frustum whose patch is another than that of exact geometry, and how well the others' 1/t agree.

    Parameters
    ----------
    rays
        Number of the rays.
    causes
        Number of differing rays by cause, see `ExactGeometry.verdict`.
    edge, depth
        Largest share of its bound that a differing ray of the cause, and 1/t of a ray of the same patch, uses.
    beyond
        Rays of the same patch whose 1/t is off by more than its bound.
    """

    rays: int
    causes: Counter
    edge: float
    depth: float
    beyond: int


class ExactGeometry:
    """Every patch against every ray in rational geometry: a patch is two triangles, a ray meets their closed sides.

    Float64 decides where its error bound permits, Python's integers elsewhere.

    Parameters
    ----------
    corners
        P x 4 x 3 integers of G; a patch's id is its index.
    matrix, origin
        Those of the frustum.
    directions
        Rows x columns x 3 integers.
    sources
        Ids of the patches that are the rays' source.

    Members
    -------
    patch
        The nearest patch of each ray, of equally near ones that of the smallest id; -1 for none. R int64.
    dropped
        R bool: the nearest patch would be one that is dropped, and therefore is no part of the geometry.
    """

    def __init__(self, *, corners, matrix, origin, directions, sources=()):
        matrix, origin, corners = (np.asarray(values).tolist() for values in (matrix, origin, corners))
        self._patches = {number: ExactPatch(corners=quad, matrix=matrix, origin=origin)
                         for number, quad in enumerate(corners) if number not in set(sources)}
        self._directions = np.asarray(directions, np.int64).reshape(-1, 3)
        tiles = RayTiles(directions)
        met = [self._met(number, triangle, tiles) for number, patch in self._patches.items()
               for triangle in range(len(patch.triangles))]
        number, ray, inverse, error = (np.concatenate(column) for column in zip(*met, strict=True))
        kept = ~np.array([patch.is_dropped for patch in self._patches.values()])
        lookup = np.zeros(len(corners), bool)
        lookup[list(self._patches)] = kept
        self._inverse = np.zeros(len(self._directions))
        everything = self._nearest(number, ray, inverse, error)
        live = lookup[number]
        self.patch = self._nearest(number[live], ray[live], inverse[live], error[live])
        self.dropped = (everything >= 0) & ~lookup[everything]

    def _met(self, number, triangle, tiles):
        """Rays that meet a triangle: the patch's number, the rays, 1/t in float64 and the bound of its error."""
        planes, normal, determinant = self._patches[number].triangles[triangle]
        loss = max(0, max(abs(c) for plane in planes for c in plane).bit_length() - TILE_BITS)
        row = tiles.met([[tuple(c >> loss for c in plane) for plane in planes]], slack=TILE_LOSS)
        ray, near = tiles.numbers(row), tiles.rays[row].astype(np.float64)
        inside, unsure = np.ones(len(row), bool), np.zeros(len(row), bool)
        for plane in planes:
            value, error = _product(near, plane)
            inside &= value >= -error
            unsure |= np.abs(value) <= error
        for index in np.flatnonzero(inside & unsure):
            exact = tiles.rays[row[index]].tolist()
            inside[index] = all(dot(plane, exact) >= 0 for plane in planes)
        value, error = _product(near[inside], normal)
        ray, unit = ray[inside], float(SCALE) / determinant
        return np.full(len(ray), number), ray, value * unit, (error + FLOAT * value) * unit

    def _nearest(self, number, ray, inverse, error):
        """The nearest patch of each ray; `_inverse` is its 1/t."""
        order = np.lexsort((number, ray))
        number, ray, inverse, error = number[order], ray[order], inverse[order], error[order]
        nearest = np.full(len(self._directions), -1)
        if not len(ray):
            return nearest
        first = np.flatnonzero(np.diff(ray, prepend=-1))
        least = np.repeat(np.maximum.reduceat(inverse - error, first), np.diff(first, append=len(ray)))
        may = inverse + error >= least
        number, ray, inverse = number[may], ray[may], inverse[may]
        first = np.flatnonzero(np.diff(ray, prepend=-1))
        nearest[ray[first]], self._inverse[ray[first]] = number[first], inverse[first]
        for start, count in zip(first, np.diff(first, append=len(ray)), strict=True):
            if count > 1:
                direction = self._directions[ray[start]].tolist()
                rivals = [(self._patches[one].inverse(direction), -one) for one in number[start:start + count].tolist()]
                best, patch = max(rivals)
                nearest[ray[start]], self._inverse[ray[start]] = -patch, float(best)
        return nearest

    def verdict(self, patch: np.ndarray, stored: np.ndarray) -> Verdict:
        """How the patches and the stored 1/t of all rays compare.

        *Tie*: the other patch is as near, exactly. *Depth*: the ray meets both, and their 1/t differ by at most the
        bounds of both. *Edge*: the ray passes an edge of a patch that one of the two hits and the other does not, by
        at most what rounding moves that edge. *Unexplained* is the rest.
        """
        causes, edge = Counter(dict.fromkeys(CAUSES, 0)), 0.0
        for ray in np.flatnonzero(patch != self.patch).tolist():
            cause, share = self._cause(int(patch[ray]), int(self.patch[ray]), self._directions[ray].tolist())
            causes[cause] += 1
            edge = max(edge, float(share))
        same = np.flatnonzero((patch == self.patch) & (patch >= 0))
        share = self._depth_shares(same, patch[same], stored[same])
        return Verdict(rays=len(patch), causes=causes, edge=edge, depth=float(share.max(initial=0)),
                       beyond=int(np.count_nonzero(share > 1)))

    def _cause(self, rounded, exact, ray):
        """The cause of one differing ray, and of an edge the share of its bound."""
        if rounded >= 0 and self._patches[rounded].is_dropped:
            return "unexplained", 0
        inverse, other = (self._patches[number].inverse(ray) if number >= 0 else None for number in (rounded, exact))
        if inverse is not None:
            if inverse == other:
                return "tie", 0
            bounds = (self._patches[number].depth_bound(ray, value) for number, value in
                      ((rounded, inverse), (exact, other)))
            if other - inverse <= sum(bounds):
                return "depth", 0
            passed = exact
        else:
            passed = rounded if rounded >= 0 else exact
        share = self._patches[passed].edge_share(ray)
        return ("unexplained", 0) if share is None else ("edge", share)

    def _depth_shares(self, ray, patch, stored):
        """The error of stored 1/t as a share of its bound, in float64, which is exact to a millionth of the share."""
        turned, steepest = np.zeros((2, max(self._patches, default=0) + 1))
        for number, one in self._patches.items():
            if not one.is_dropped:
                turned[number], steepest[number] = one.turned, one.steepest
        inverse, size = self._inverse[ray], np.abs(self._directions[ray]).sum(axis=1)
        value = np.ldexp(1 + (stored & ((1 << STORED) - 1)) * 2.0**-STORED, (stored >> STORED) - BIAS)
        bound = inverse * (turned[patch] + 2.0**-18) + 2.0**-22 * steepest[patch] * size + 2.0**-38
        return np.abs(value - inverse) / bound


def _product(rays, vector):
    """The products of rays with a vector of Python's integers, and the bounds of their errors."""
    vector = np.array([float(component) for component in vector])
    return rays @ vector, FLOAT * (np.abs(rays) @ np.abs(vector))
