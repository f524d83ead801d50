"""The rule of docs/fixed-point.md and docs/exactness.md, in integers: hits of rays by every patch against every ray."""

from dataclasses import dataclass

import numpy as np

from benchmarks.truth.integers import scaled
from benchmarks.truth.ray_tiles import RayTiles
from benchmarks.truth.rule_patch import DIAGONALS, EDGES, RulePatch

__all__ = ["IntegerRule", "RuleHits"]

# Fraction bits of directions and matrices; of a stored 1/t the fraction's bits and the exponent's bias and bits.
DIRECTION, FRACTION, BIAS, EXPONENT = 16, 18, 39, 6
# Bits of the largest aligned distance, and of u and v.
ALIGNED, STEPS = 24, 8


@dataclass(frozen=True, eq=False)
class RuleHits:
    """Hits of R rays in the order of their numbers: patch (-1 for none), stored 1/t, u and v, R int64 each."""

    patch: np.ndarray
    inverse: np.ndarray
    u: np.ndarray
    v: np.ndarray


class IntegerRule:
    """The nearest hits of rays from one origin, by steps 1 to 9 of docs/fixed-point.md.

    Parameters
    ----------
    corners
        P x 4 x 3 integers of G; a patch's id is its index.
    matrix, origin
        Those of the frustum.
    sources
        Ids of the patches that are the rays' source.
    numbers
        Type of the numbers of rays: int64, beyond which none of the page's formats goes, or object, for Python's
        integers, which have no range.
    """

    def __init__(self, *, corners, matrix, origin, sources=(), numbers: type = np.int64):
        matrix, origin, corners = (np.asarray(values).tolist() for values in (matrix, origin, corners))
        sources = set(sources)
        patches = {number: RulePatch(corners=quad, matrix=matrix, origin=origin)
                   for number, quad in enumerate(corners) if number not in sources}
        self._patches = {number: patch for number, patch in patches.items() if patch.parts and not patch.is_dropped}
        self._numbers = numbers

    def cast(self, directions) -> RuleHits:
        """The hits of the rays of rows x columns x 3 directions."""
        tiles = RayTiles(directions)
        rays = tiles.rays.astype(self._numbers)
        hits = RuleHits(*(np.full(len(rays), empty) for empty in (-1, 0, 0, 0)))
        pairs = [(np.full(len(ray), number), ray, held) for number, patch in self._patches.items()
                 for ray, held in [self._inside(patch, tiles, rays)]]
        if pairs:
            number, ray, held = (np.concatenate(column) for column in zip(*pairs, strict=True))
            stored = self._stored(number, rays[ray])
            # The nearest patch of each ray last: the one of the larger 1/t, of equal ones the smaller id.
            order = np.lexsort((-number, stored.astype(np.int64), ray))
            last = order[np.flatnonzero(np.diff(ray[order], append=-1))]
            number, ray, held = number[last], ray[last], held[last]
            where = tiles.numbers(ray)
            hits.patch[where], hits.inverse[where] = number, stored[last]
            hits.u[where], hits.v[where] = self._bisected(number, rays[ray], held)
        return hits

    def _inside(self, patch, tiles, rays):
        """Rays that are inside a part of a patch, and the orientation that held first."""
        ray = tiles.met([[scaled(plane, orientation) for plane in planes] for orientation, planes in patch.parts])
        near, held = rays[ray], np.zeros(len(ray), self._numbers)
        for orientation, planes in reversed(patch.parts):
            inside = np.ones(len(ray), bool)
            for plane in planes:
                inside &= _holds(_dot(scaled(plane, orientation), near.T) >= 0)
            held[inside] = orientation
        inside = _holds(held != 0)
        return ray[inside], held[inside]

    def _stored(self, number, rays):
        """1/t of rays inside the edges of patches, as it is stored."""
        product = _dot([self._gathered(number, lambda patch, axis=axis: patch.m[axis]) for axis in range(3)], rays.T)
        length = _bit_lengths(np.maximum(product, 1))
        exponent = length - 1 - DIRECTION + self._gathered(number, lambda patch: patch.exponent) + BIAS
        # The mantissa's leading one counts as one in the exponent.
        stored = ((exponent - 1) << FRACTION) + (np.maximum(product, 1) << FRACTION >> (length - 1))
        return np.where(product > 0, np.clip(stored, 1, 2 ** (EXPONENT + FRACTION) - 1), 1)

    def _bisected(self, number, rays, held):
        """The position (u, v) on the patches that rays hit."""
        exact, exponents = [], []
        for pair in EDGES + DIAGONALS:
            plane = [self._gathered(number, lambda patch, pair=pair, axis=axis: patch.planes[pair][axis])
                     for axis in range(3)]
            exact.append(_dot(plane, rays.T))
            exponents.append(self._gathered(number, lambda patch, pair=pair: patch.exponents[pair]))
        tops = [np.where(distance != 0, _bit_lengths(abs(distance)) + exponent, -(2**20))
                for distance, exponent in zip(exact, exponents, strict=True)]
        unit = np.max(tops, axis=0) - ALIGNED
        d01, d12, d23, d30, d02, d13 = (held * _aligned(distance, unit - exponent)
                                        for distance, exponent in zip(exact, exponents, strict=True))
        u, v = 0 * held, 0 * held
        for _ in range(STEPS):
            e = (d02 - d30 + d12 + d13) >> 2
            left = _holds(e >= 0)
            u = 2 * u + ~left
            d01, d12, d23, d30, d02, d13 = (
                d01 >> 1, np.where(left, e, d12), d23 >> 1, np.where(left, d30, -e),
                np.where(left, d02 - d30, d02 + d12) >> 1, np.where(left, d13 - d30, d13 + d12) >> 1)
            e = (d01 + d02 - d13 - d23) >> 2
            lower = _holds(e <= 0)
            v = 2 * v + ~lower
            d01, d12, d23, d30, d02, d13 = (
                np.where(lower, d01, e), d12 >> 1, np.where(lower, -e, d23), d30 >> 1,
                np.where(lower, d02 + d01, d02 - d23) >> 1, np.where(lower, d13 - d01, d13 + d23) >> 1)
        return u, v

    def _gathered(self, number, value):
        """A number of each of the patches ``number``."""
        table = np.zeros(max(self._patches) + 1, self._numbers)
        for index, patch in self._patches.items():
            table[index] = value(patch)
        return table[number]


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _holds(conditions):
    """Conditions as bool, which comparisons of objects are not."""
    return np.asarray(conditions, bool)


def _bit_lengths(magnitudes):
    """The bits of each; float64 holds all integers below 2^53."""
    if magnitudes.dtype == object:
        return np.array([magnitude.bit_length() for magnitude in magnitudes.tolist()], object)
    return np.frexp(magnitudes.astype(np.float64))[1].astype(np.int64)


def _aligned(values, shifts):
    """``values`` / 2^``shifts``, to nearest and half away from zero; of 53 bits none is left after a shift by 55."""
    down = np.clip(shifts, 0, 55)
    magnitude = (abs(values) + ((1 << down) >> 1)) >> down << np.clip(-shifts, 0, ALIGNED)
    return np.where(values < 0, -magnitude, magnitude)
