"""Rays that find how much of the sky sides see, and where."""

import numpy as np

from golden.cast.casters import CastsRays
from golden.cast.rays import Rays
from golden.light.factors.draws import hemisphere_rays
from golden.light.factors.number_blocks import number_blocks
from golden.light.factors.points import REPLICATES
from golden.light.factors.replicate_shares import replicate_shares
from golden.light.factors.sides import Sides
from golden.light.factors.sky_division import SkyDivision

__all__ = ["SkyRays", "patch_errors"]

# Standard errors by which rays refute a share.
_REFUTED = 5

# Rays per block, which bounds memory.
_BLOCK = 1 << 18


class SkyRays:
    """Rays from R sides that leave the scene.

    Parameters
    ----------
    sides, caster
        The sides, and a caster with ``any_hit``.
    row
        R int: numbers of the sides.
    use
        R uint64: the use of each side's random numbers (`golden.light.sampling.mix`).
    division
        Of the sky. Default: it is one.

    Members
    -------
    patches
        R x P int32: rays that left through each of the P patches of the sky; P = 0 without a division.
    rays
        R int64: rays of each side that `shares` has counted.
    """

    def __init__(self, sides: Sides, caster: CastsRays, row: np.ndarray, use: np.ndarray, *,
                 division: SkyDivision | None = None):
        self._sides, self._caster, self._row, self._use, self._division = sides, caster, row, use, division
        self._left = np.zeros((len(row), REPLICATES), dtype=np.int64)
        self.patches = np.zeros((len(row), 0 if division is None else len(division)), dtype=np.int32)
        self.rays = np.zeros(len(row), dtype=np.int64)

    def add(self, own: np.ndarray, number: np.ndarray, direction: np.ndarray) -> None:
        """Count K rays that left.

        Parameters
        ----------
        own, number
            K int: the side of each, counted from 0, and its number in the side's hemisphere.
        direction
            K x 3.
        """
        self._left += self._counts(own * REPLICATES + number % REPLICATES, self._left.shape)
        if self._division is not None:
            slot = own * len(self._division) + self._division.numbers(direction)
            self.patches += self._counts(slot, self.patches.shape).astype(np.int32)

    @property
    def left(self) -> np.ndarray:
        """R int64: rays of each side that left."""
        return self._left.sum(axis=1)

    def shares(self, rays: int, *, limit: float, most: int,
               known: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """The share of each side's rays that leave, and its standard error, R float64 each.

        Sides whose error, or that of a patch of the sky (`patch_errors`), is above the limit get more rays, until it is
        not or they have ``most``. An error that was above the limit is not below it then: of several estimates one that
        is too small ends the search. A known share that the first rays do not refute has no error, and needs rays for a
        division of the sky alone.

        Parameters
        ----------
        rays
            Rays of each side that were cast.
        limit
            Standard error from which on a side gets more rays.
        most
            Rays of a side, at most.
        known
            R float64: exact shares, NaN where there is none. Default: there is none.
        """
        cast, least = np.full(len(self._row), rays), np.zeros(len(self._row))
        settled = None
        while True:
            whole = np.repeat(cast[:, None] / REPLICATES, REPLICATES, axis=1)
            share, error = replicate_shares(whole, self._left, cast)
            error = np.maximum(error, least)
            if settled is None:  # patches that overlap have factors too large
                settled = np.zeros(len(share), dtype=bool) if known is None else (
                    np.abs(known - share) <= _REFUTED * error)
            done = settled if self._division is None else np.zeros(len(share), dtype=bool)
            worst = np.maximum(error, patch_errors(self.patches, cast).max(axis=1, initial=0))
            short = np.flatnonzero((worst > limit) & (cast < most) & ~done)
            if not len(short):
                self.rays = cast
                return np.where(settled, 0.0 if known is None else known, share), np.where(settled, 0.0, error)
            least[error > limit] = limit
            growth = np.clip((worst[short] / limit)**2, 1.25, 4)
            target = np.ceil(cast[short] * growth / REPLICATES).astype(np.int64) * REPLICATES
            more = np.clip(target, REPLICATES, most) - cast[short]
            self._cast(short, cast[short], more)
            cast[short] += more

    def _cast(self, own, first, more):
        """Cast so many more rays of some sides, from the number ``first`` on."""
        for entry, number in number_blocks(first, more, _BLOCK):
            side = own[entry]
            row = self._row[side]
            origin, direction = hemisphere_rays(self._sides, row, self._use[side], number)
            free = np.flatnonzero(~self._caster.blocked(Rays(origin, direction, source=self._sides.surface[row])))
            self.add(side[free], number[free], direction[free])

    @staticmethod
    def _counts(slot, shape):
        return np.bincount(slot, minlength=shape[0] * shape[1]).reshape(shape)


def patch_errors(counts: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Standard errors of the shares of rays that leave through patches of the sky, R x P float64.

    By Wilson at two standard deviations, as in `golden.light.factors.replicate_shares`: no less than those of rays that
    fill the hemisphere more evenly than by chance.

    Parameters
    ----------
    counts
        R x P: rays that left through each patch.
    rays
        R: all rays of each side.
    """
    count = np.asarray(rays, dtype=np.float64)[:, None]
    share = np.divide(counts, count, out=np.zeros(counts.shape), where=count > 0)
    return (np.abs(1 - 2 * share) + np.sqrt(count * share * (1 - share) + 1)) / (count + 4)
