"""Rows of view factors: what each side sees, by closed forms and rays."""

import numpy as np

from golden.cast.rays import Rays
from golden.compiled import is_compiler_active
from golden.errors import InputError
from golden.light.factors.draws import hemisphere_rays
from golden.light.factors.join import join
from golden.light.factors.pair_factors import exchange_areas
from golden.light.factors.pair_kernel import candidates, may_exceed
from golden.light.factors.points import REPLICATES
from golden.light.factors.projection import project
from golden.light.factors.row_block import RowBlock
from golden.light.factors.sides import Sides
from golden.light.factors.view_factors import CLOSED, ViewFactors
from golden.light.factors.visibility import visible_shares
from golden.light.sampling import mix
from golden.scene.scene import Scene

__all__ = ["FactorRows"]

# Rays of a hemisphere: 1 / error within these bounds.
_FEWEST_RAYS, _MOST_RAYS = 256, 4096

# Pairs, and rays, per block, which bounds memory.
_PAIRS, _RAYS = 1 << 21, 1 << 18

# Rows that do not close are measured again with these shares of the error, those that miss it by less than this share
# of the worst one last: they may close as it does.
_FINER, _WORST = (1 / 4, 1 / 16, 1 / 64, 1 / 64, 1 / 64), 0.1

# Keys of the random numbers' uses.
_HEMISPHERES, _SEGMENTS = 0, 1


class FactorRows:
    """Rows of the view factors of a scene, computed in blocks that do not depend on each other.

    Each row casts a hemisphere of rays, which finds what it sees. Pairs whose factor without occlusion exceeds half
    the requested error are measured by segments, from the smaller patch (`visible_shares`). Smaller factors come from
    the hits of both hemispheres alone. Rows and columns are the scene's `Sides`.

    Some rows miss a factor that no ray met, or one of many estimates is far off, and then nothing within the errors
    closes the row. Such rows are measured again, finer, with all of their pairs.

    Parameters
    ----------
    scene
        The patches.
    caster
        A caster with ``nearest_patches`` and ``occluded``, such as `golden.cast.grid.Grid`.
    error
        Requested error of every factor: twice its standard error, 1e-6 to 0.1.
    seed
        Of the random numbers, at least 0.
    block_rows
        Rows of a block of work; they do not depend on it.

    Members
    -------
    kind, block_rows
        The class of blocks, and the rows of one.
    settings
        What the values depend on beside the scene and the caster.
    rays
        Rays of a row's hemisphere.

    Raises
    ------
    InputError
        Error or seed out of range.
    """

    kind = RowBlock

    def __init__(self, scene: Scene, caster, *, error: float = 1e-3, seed: int = 0, block_rows: int = 128):
        if not 1e-6 <= error <= 0.1:
            raise InputError(f"view factors: Error must be 1e-6 to 0.1, not {error!r}")
        if not isinstance(seed, (int, np.integer)) or isinstance(seed, bool) or not 0 <= seed < 2**63:
            raise InputError(f"view factors: Seed must be an integer from 0 to 2^63 - 1, not {seed!r}")
        self._sides, self._caster, self._error, self._seed = Sides(scene), caster, error, seed
        self.block_rows = block_rows
        self.settings = {"error": error, "seed": seed}
        self.rays = int(np.clip(np.ceil(1 / error / REPLICATES) * REPLICATES, _FEWEST_RAYS, _MOST_RAYS))

    def __len__(self) -> int:
        return len(self._sides)

    def rows(self, first: int, last: int) -> RowBlock:
        """The rows ``first`` to ``last`` - 1."""
        return self._block(first, last, rays=self.rays, limit=self._error / 2)

    def _block(self, first, last, *, rays, limit, whole=False):
        """Rows by so many rays each and factors to a standard error, of all pairs or of those that the rows own."""
        row, column, hits, sky, back, sky_error = self._hemispheres(first, last, rays)
        pairs = self._measured(first, last, limit, whole)
        count, width = last - first, len(self)
        key = np.concatenate([(row - first) * width + column, (pairs["row"] - first) * width + pairs["column"]])
        entry, inverse = np.unique(key, return_inverse=True)
        from_hits, from_pairs = inverse[:len(row)], inverse[len(row):]
        hit, factor, error = np.zeros(len(entry), np.int32), np.full(len(entry), np.nan), np.full(len(entry), np.nan)
        hit[from_hits] = hits
        factor[from_pairs], error[from_pairs] = pairs["factor"], pairs["error"]
        keep = np.flatnonzero((hit > 0) | (factor > 0))
        hidden_error = np.zeros(count)
        hidden = pairs["factor"] == 0
        np.maximum.at(hidden_error, pairs["row"][hidden] - first, pairs["error"][hidden])
        entry = entry[keep]
        start = np.searchsorted(entry, np.arange(count + 1) * width)
        return RowBlock(start=start, column=(entry % width).astype(np.int32), hits=hit[keep],
                        factor=factor[keep], error=error[keep], rays=np.full(count, rays), sky=sky, back=back,
                        sky_error=sky_error, hidden_error=hidden_error)

    def join(self, blocks) -> ViewFactors:
        """The view factors of the blocks of all rows, in their order, closed and reciprocal (`project`)."""
        sides, scene, blocks = self._sides, self._sides.scene, list(blocks)
        reached = np.ones(len(self))
        for finer in (*_FINER, None):
            estimate = join(blocks, area=sides.area, error=self._error)
            F, sky, back = project(estimate, area=sides.area)
            missed = np.abs(F.sum(axis=1) + sky + back - 1)
            if finer is None or missed.max() <= CLOSED:
                break
            # The same work again would give the same bits.
            again = (missed > max(CLOSED, _WORST * missed.max())) & (reached > finer)
            if not again.any():
                break
            reached[again] = finer
            blocks = self._refined(blocks, again, finer)
        names = np.array([material.name for material in scene.materials])
        return ViewFactors(F=F, sky=sky, back=back, area=sides.area, normal=sides.normal, patch=sides.patch,
                           front=sides.front, surface=names[scene.material[sides.patch]], error=estimate.error,
                           hidden_error=estimate.hidden_error, unprojected=estimate.F, unprojected_sky=estimate.sky,
                           settings=self.settings)

    def _refined(self, blocks, again, finer):
        """The blocks with some of their rows measured again, to a share of the error."""
        refined, first = [], 0
        for block in blocks:
            last = first + len(block.sky)
            begin = first
            for row in first + np.flatnonzero(again[first:last]):
                refined += [block[begin - first:row - first], self._block(
                    row, row + 1, rays=round(self.rays / finer), limit=self._error * finer / 2, whole=True)]
                begin = row + 1
            refined.append(block[begin - first:last - first])
            first = last
        return refined

    def _hemispheres(self, first, last, rays):
        """Rows, columns and counts of hits; rays that leave, rays that meet a black back, error of the former."""
        sides, width = self._sides, len(self)
        keys, left, back = [], np.zeros((last - first, REPLICATES), np.int64), np.zeros(last - first, np.int64)
        step = max(1, _RAYS // rays)
        for low in range(first, last, step):
            row = np.repeat(np.arange(low, min(low + step, last)), rays)
            number = np.arange(len(row)) % rays
            origin, direction = hemisphere_rays(sides, row, mix(self._seed, _HEMISPHERES, row), number)
            patch = self._caster.nearest_patches(Rays(origin, direction, source=sides.surface[row]))
            slot = (row - first) * REPLICATES + number % REPLICATES
            left += np.bincount(slot[patch < 0], minlength=left.size).reshape(left.shape)
            met = np.flatnonzero(patch >= 0)
            side = sides.met(patch[met], direction[met])
            back += np.bincount(row[met[side < 0]] - first, minlength=len(back))
            keys.append((row[met] * width + side)[side >= 0])
        key, count = np.unique(np.concatenate(keys), return_counts=True)
        sky = left.sum(axis=1)
        share = sky / rays
        few = np.minimum(sky, rays - sky) < REPLICATES
        middle = (sky + 0.5) / (rays + 1)
        error = np.where(few, np.sqrt(middle * (1 - middle) / (rays + 1)),
                         np.std(left / (rays / REPLICATES), axis=1, ddof=1) / np.sqrt(REPLICATES))
        # A row without a ray that leaves is closed.
        return key // width, key % width, count, sky, back, np.where(share == 0, 0.0, error)

    def _measured(self, first, last, limit, whole):
        """The pairs of these rows that segments measure."""
        sides = self._sides
        found = []
        step = max(1, _PAIRS // len(self) // 4)
        for low in range(first, last, step):
            row, column = self._candidates(np.arange(low, min(low + step, last)), limit, whole)
            factor = exchange_areas(sides.vertices[row], sides.vertices[column]) / sides.area[row]
            large = np.flatnonzero(factor > limit)
            found.append((row[large], column[large], factor[large]))
        row, column, factor = (np.concatenate(part) for part in zip(*found, strict=True))
        shares = visible_shares(sides, self._caster, row, column, factor, limit=limit,
                                seed=int(mix(self._seed, _SEGMENTS)))
        return {"row": row, "column": column, "factor": factor * shares.share, "error": factor * shares.error}

    def _candidates(self, rows, limit, whole):
        """The pairs of rows and columns that these rows measure and whose factor may exceed the limit."""
        sides = self._sides
        if is_compiler_active():
            return candidates(rows, sides.centre, sides.normal, sides.radius, sides.area, limit, whole)
        every = (np.arange(len(self)), *sides.centre.T, *sides.normal.T, sides.radius, sides.area)
        row, column = np.nonzero(may_exceed(*(value[rows][:, None] for value in every), *every, limit, whole))
        return rows[row], column
