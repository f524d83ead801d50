"""The visible share of pairs of patches, by segments between them."""

import numpy as np

from golden.cast.casters import CastsRays
from golden.light.factors.certain import certain_shares
from golden.light.factors.draws import segments_by_direction, segments_by_points
from golden.light.factors.number_blocks import number_blocks
from golden.light.factors.points import REPLICATES
from golden.light.factors.replicate_shares import replicate_shares
from golden.light.factors.sides import Sides
from golden.light.sampling import mix

__all__ = ["visible_shares"]

# Pairs whose radii sum to more than this share of their distance, and whose factor is above this, are joined by
# directions, unless the kernel is even: a gap of this share of the smaller radius separates them, and so many trial
# segments between points on both count as this share of equal ones. For all others points on both serve.
_NEAR, _NEAR_FACTOR = 0.7, 2e-3
_GAP, _TRIALS, _EVEN = 0.3, 64, 0.4

# Segments per block, which bounds memory.
_BLOCK = 1 << 18

# First segments of a pair, and the most.
_FIRST, _MOST = 16, 1 << 22


def visible_shares(sides: Sides, caster: CastsRays, first: np.ndarray, second: np.ndarray, factor: np.ndarray, *,
                   limit: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Shares of the light between pairs, if nothing were in between, that pass; weighted by cos cos / r^2.

    A pair first gets as many segments as it needs if all of them agree. If they do, and many more are needed,
    geometry decides if it can; all others get more segments until the estimate is good enough, or there are 2^22. Then
    a factor's error is not below the limit: of several estimates one that is too small ends the search.

    Parameters
    ----------
    sides, caster
        The sides, and a caster with ``occluded`` (`golden.cast.grid.Grid`).
    first, second
        P int: the sides of each pair.
    factor
        P float64: view factors from the first to the second, without occlusion, above 0.
    limit
        Largest standard error of factor times share, as far as 2^22 segments reach it.
    seed
        Of the segments; those of a pair do not depend on other pairs.

    Returns
    -------
    P float64 each: the shares and their standard errors, 0 where geometry decided.
    """
    sampling = _Sampling(sides, caster, first, second, factor, seed)
    exact, again = np.zeros((2, len(first)), dtype=bool)
    certain = np.zeros(len(first))
    needed = np.maximum(1, np.ceil(2 * factor / limit) - 4)
    sampling.extend(np.arange(len(first)), np.minimum(needed, _FIRST))
    share, error = sampling.estimate(slice(None))
    # A test of one patch against a pair costs about as much as a segment's share of a ray.
    agreed = np.flatnonzero(((share == 0) | (share == 1)) & (factor * error > limit)
                            & (needed * 16 > len(sides.scene)))
    decided, value = certain_shares(sides, first[agreed], second[agreed])
    exact[agreed[decided]] = True
    certain[agreed[decided]] = value[decided]
    while True:
        rows = np.flatnonzero(~exact & (factor * error > limit) & (sampling.count < _MOST))
        if not len(rows):
            break
        ratio = factor[rows] * error[rows] / limit
        agree = (share[rows] == 0) | (share[rows] == 1)
        growth = np.where(agree, np.minimum(ratio, 16), np.minimum(ratio**2, 4)) * 1.1
        sampling.extend(rows, np.minimum(sampling.count[rows] * np.maximum(growth, 1.25), _MOST))
        share[rows], error[rows] = sampling.estimate(rows)
        again[rows] = True
    again &= (share > 0) & (share < 1)
    error[again] = np.maximum(error[again], np.nextafter(limit / factor[again], 0))
    return np.where(exact, certain, share), np.where(exact, 0.0, error)


class _Sampling:
    """Segments between pairs and their sums by replicate."""

    def __init__(self, sides, caster, first, second, factor, seed):
        self._sides, self._caster = sides, caster
        self._first, self._second = first, second
        self._uses = mix(seed, first, second)
        distance = np.linalg.norm(sides.centre[first] - sides.centre[second], axis=1)
        near = (sides.radius[first] + sides.radius[second] > _NEAR * distance) & (factor > _NEAR_FACTOR)
        rows = np.flatnonzero(near)
        apart = rows[self._gaps(rows) > _GAP]
        near[apart] = self._evenness(apart) < _EVEN
        # Of the directions from the first patch a share of about the factor meets the second.
        self._tries = np.where(near, 1 / factor, 0.0)
        shape = len(first), REPLICATES
        self._all, self._seen = np.zeros(shape), np.zeros(shape)
        self._squares = np.zeros(len(first))
        self._drawn = np.zeros(len(first), dtype=np.int64)
        self.count = np.zeros(len(first))

    def extend(self, rows, count):
        """Draw for the pairs ``rows`` until they have about ``count`` segments."""
        drawn = np.ceil(count * np.maximum(1, self._tries[rows])).astype(np.int64)
        # Whole turns of all replicates, but for the very first points.
        drawn = np.where(drawn > REPLICATES // 2, -(-drawn // REPLICATES) * REPLICATES, drawn)
        more = np.maximum(drawn - self._drawn[rows], 0)
        for entry, number in number_blocks(self._drawn[rows], more, _BLOCK):
            self._cast(rows[entry], number)
        self._drawn[rows] += more
        self.count[rows] = count

    def estimate(self, rows):
        """Shares of the pairs ``rows`` and their standard errors."""
        return replicate_shares(self._all[rows], self._seen[rows], self._squares[rows])

    def _gaps(self, rows):
        """The larger height of either patch of pairs over the other one's plane, in the smaller radius."""
        sides, first, second = self._sides, self._first[rows], self._second[rows]
        over, under = (np.einsum("pki,pi->pk", sides.vertices[other] - sides.centre[own, None], sides.normal[own])
                       for own, other in ((first, second), (second, first)))
        return np.maximum(over.min(axis=1), under.min(axis=1)) / np.minimum(sides.radius[first], sides.radius[second])

    def _evenness(self, rows):
        """The equal segments, over all, that count as much as the trial segments of the pairs ``rows``."""
        evenness = np.zeros(len(rows))
        for start in range(0, len(rows), _BLOCK // _TRIALS):
            pair = np.repeat(rows[start:start + _BLOCK // _TRIALS], _TRIALS)
            number = np.arange(len(pair)) % _TRIALS
            first, second = self._first[pair], self._second[pair]
            weight = segments_by_points(self._sides, first, second, mix(self._uses[pair], 1), number)[2]
            weight = weight.reshape(-1, _TRIALS)
            squares = _TRIALS * np.einsum("pt,pt->p", weight, weight)
            evenness[start:start + len(weight)] = np.divide(
                weight.sum(axis=1)**2, squares, out=np.zeros(len(weight)), where=squares > 0)
        return evenness

    def _cast(self, pair, number):
        """Add the segments ``number`` of pairs, which are in order."""
        near = self._tries[pair] > 0
        origin, target = np.empty((2, len(pair), 3))
        weight = np.empty(len(pair))
        for which, draw in ((near, segments_by_direction), (~near, segments_by_points)):
            which = np.flatnonzero(which)
            those = pair[which]
            origin[which], target[which], weight[which] = draw(
                self._sides, self._first[those], self._second[those], self._uses[those], number[which])
        rows = np.flatnonzero(weight > 0)
        pair, number, weight = pair[rows], number[rows], weight[rows]
        surface = self._sides.surface
        skip = np.stack([surface[self._first[pair]], surface[self._second[pair]]], axis=1)
        seen = ~self._caster.occluded(origin[rows], target[rows], skip)
        if not len(pair):
            return
        # A block's pairs are in order.
        own = slice(pair[0], pair[-1] + 1)
        pair -= pair[0]
        slot = pair * REPLICATES + number % REPLICATES
        for sums, values in ((self._all[own], weight), (self._seen[own], weight * seen)):
            sums += np.bincount(slot, values, sums.size).reshape(sums.shape)
        self._squares[own] += np.bincount(pair, weight**2)
