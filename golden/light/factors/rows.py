"""Rows of view factors: what each side sees, by closed forms and rays."""

from numbers import Real

import numpy as np
from scipy import sparse

from golden.base.errors import InputError
from golden.cast.casters import CastsRays
from golden.cast.rays import Rays
from golden.light.factors.blocks import scene_key
from golden.light.factors.coincident_fronts import CoincidentFronts
from golden.light.factors.draws import hemisphere_rays
from golden.light.factors.exact_sky import FEW_TESTS, exact_sky
from golden.light.factors.factor_matrix import CLOSED
from golden.light.factors.join import join
from golden.light.factors.pair_factors import exchange_areas
from golden.light.factors.pair_kernel import candidates
from golden.light.factors.points import REPLICATES
from golden.light.factors.projection import project
from golden.light.factors.row_block import RowBlock
from golden.light.factors.sides import Sides
from golden.light.factors.sky_division import SKY_DIVISIONS, SkyDivision
from golden.light.factors.sky_rays import SkyRays, patch_errors
from golden.light.factors.view_factors import ViewFactors
from golden.light.factors.visibility import visible_shares
from golden.light.sampling import mix
from golden.scene.scene import Scene

__all__ = ["FactorRows"]

# Rays of a hemisphere: 1 / error within these bounds. The sky's share gets up to as many, or so many by an error.
_FEWEST_RAYS, _MOST_RAYS, _MOST_SKY_RAYS = 256, 4096, 1 << 20

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

    The sky is what rays of hemispheres miss. Rows get more of these rays until the sky's error is the requested one.
    Where geometry decides all factors of a row (`exact_sky`), it is the rest of these.

    Some rows miss a factor that no ray met, or one of many estimates is far off, and then nothing within the errors
    closes the row. Such rows are measured again, finer, with all of their pairs.

    Parameters
    ----------
    caster
        A caster with ``nearest_patches`` and ``occluded``, such as `golden.cast.grid.Grid`.
    error
        Requested error of every factor: twice its standard error, 1e-6 to 0.1. It is reached as far as 2^22 segments
        of a pair do.
    sky_error
        The same of every sky view factor. Default: that of the factors, as far as 4096 rays of a row reach it.
    sky_patches
        Name of a division of the sky (`SKY_DIVISIONS`) around the scene's up whose patches' shares are measured too.
        Default: none.
    seed
        Of the random numbers, at least 0.
    block_rows
        Rows of a block of work; they do not depend on it.

    Members
    -------
    kind, block_rows, jobs
        The class of blocks, the rows of one, and the blocks that may be computed at once.
    settings
        What the values depend on beside the caster; of the scene the `scene_key`.
    rays
        Rays of a row's hemisphere.

    Raises
    ------
    InputError
        An error or the seed is out of range, or there is no such division.
    """

    kind = RowBlock

    def __init__(self, scene: Scene, caster: CastsRays, *, error: float = 1e-3, sky_error: float | None = None,
                 sky_patches: str | None = None, seed: int = 0, block_rows: int = 128):
        for name, value in (("Error", error), ("Sky error", error if sky_error is None else sky_error)):
            if not isinstance(value, Real) or not 1e-6 <= value <= 0.1:
                raise InputError(f"view factors: {name} must be 1e-6 to 0.1, not {value!r}", parameter=name)
        if not isinstance(seed, (int, np.integer)) or isinstance(seed, bool) or not 0 <= seed < 2**63:
            raise InputError(f"view factors: Seed must be an integer from 0 to 2^63 - 1, not {seed!r}",
                             parameter="seed")
        if sky_patches is not None and sky_patches not in SKY_DIVISIONS:
            raise InputError(f"view factors: Sky patches must be {' or '.join(SKY_DIVISIONS)}, not {sky_patches!r}")
        self._own = self._sides = Sides(scene)
        self._caster, self._error, self._seed = caster, error, seed
        self._fronts = CoincidentFronts(self._sides)
        self._sky_limit = (error if sky_error is None else sky_error) / 2
        self._most_sky_rays = _MOST_RAYS if sky_error is None else _MOST_SKY_RAYS
        self.block_rows = block_rows
        self._division = None if sky_patches is None else SkyDivision(sky_patches, scene.up)
        optional = {"sky_error": sky_error, "sky_patches": sky_patches,
                    "zenith": None if sky_patches is None else list(map(float, scene.up))}
        self.settings = {"scene": scene_key(scene), "error": error, "seed": seed} | {
            name: value for name, value in optional.items() if value is not None}
        self.rays = int(np.clip(np.ceil(1 / error / REPLICATES) * REPLICATES, _FEWEST_RAYS, _MOST_RAYS))

    @property
    def jobs(self) -> int:
        """Those of the caster."""
        return self._caster.jobs

    def __len__(self) -> int:
        return len(self._own)

    def rows(self, first: int, last: int) -> RowBlock:
        """The rows ``first`` to ``last`` - 1."""
        return self._block(first, last, rays=self.rays, limit=self._error / 2)

    def _block(self, first, last, *, rays, limit, all_pairs=False):
        """Rows by so many rays each; factors to a standard error, of all pairs or of those that the rows measure."""
        row, column, hits, back, sky_rays = self._hemispheres(first, last, rays)
        sky, sky_error = sky_rays.shares(rays, limit=self._sky_limit, most=self._most_sky_rays,
                                         known=self._known_sky(first, row - first, back, sky_rays.left))
        pairs = self._measured(first, last, limit, all_pairs)
        count, width = last - first, len(self._sides)
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
                        sky_error=sky_error, sky_patches=sky_rays.patches, sky_rays=sky_rays.rays,
                        hidden_error=hidden_error)

    def join(self, blocks) -> ViewFactors:
        """The view factors of the blocks of all rows, in their order, closed and reciprocal (`project`)."""
        sides, scene, blocks = self._own, self._own.scene, list(blocks)
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
        open_rows = missed > CLOSED
        if open_rows.any():
            # Rows that nothing closes must not pull their factors as far as the errors allow.
            F, sky, back = project(estimate, area=sides.area, ignored=open_rows)
        shares = errors = None
        if self._division:
            shares, errors = _sky_patches(sky, *(np.concatenate([getattr(block, name) for block in blocks])
                                                 for name in ("sky_patches", "sky_rays")))
        names = np.array([material.name for material in scene.materials])
        return ViewFactors(F=F, sky=sky, back=back, area=sides.area, normal=sides.normal, patch=sides.patch,
                           front=sides.front, surface=names[scene.material[sides.patch]], error=estimate.error,
                           hidden_error=estimate.hidden_error, unprojected=estimate.F, unprojected_sky=estimate.sky,
                           settings=self.settings,
                           sky_error=np.where(open_rows, estimate.sky_error, estimate.closed_sky_error),
                           sky_patches=shares, sky_patches_error=errors)

    def _refined(self, blocks, again, finer):
        """The blocks with some of their rows measured again, to a share of the error."""
        refined, first = [], 0
        for block in blocks:
            last = first + len(block.sky)
            begin = first
            for row in first + np.flatnonzero(again[first:last]):
                refined += [block[begin - first:row - first], self._block(
                    row, row + 1, rays=round(self.rays / finer), limit=self._error * finer / 2, all_pairs=True)]
                begin = row + 1
            refined.append(block[begin - first:last - first])
            first = last
        return refined

    def _hemispheres(self, first, last, rays):
        """Rows, columns and counts of hits; rays that meet a black back; and those that leave."""
        sides, width = self._sides, len(self._sides)
        rows = np.arange(first, last)
        uses = mix(self._seed, _HEMISPHERES, rows)
        sky = SkyRays(sides, self._caster, rows, uses, division=self._division)
        keys, back = [], np.zeros(len(rows), np.int64)
        step = max(1, _RAYS // rays)
        for low in range(first, last, step):
            row = np.repeat(np.arange(low, min(low + step, last)), rays)
            number = np.arange(len(row)) % rays
            origin, direction = hemisphere_rays(sides, row, uses[row - first], number)
            patch = self._caster.nearest_patches(Rays(origin, direction, source=sides.surface[row]))
            left = np.flatnonzero(patch < 0)
            sky.add(row[left] - first, number[left], direction[left])
            met = np.flatnonzero(patch >= 0)
            side = sides.met(patch[met], direction[met])
            black = np.flatnonzero(side < 0)
            behind = met[black]
            side[black] = self._fronts.met(patch[behind], origin[behind], direction[behind])
            back += np.bincount(row[met[side < 0]] - first, minlength=len(back))
            keys.append((row[met] * width + side)[side >= 0])
        key, count = np.unique(np.concatenate(keys), return_counts=True)
        return key // width, key % width, count, back, sky

    def _known_sky(self, first, own, back, left):
        """The shares of the sky that geometry decides, NaN of other rows."""
        known = np.full(len(back), np.nan)
        seen = np.bincount(own, minlength=len(back))
        few = np.flatnonzero((seen * len(self._sides.scene) <= FEW_TESTS) & (back == 0) & (left > 0))
        if len(few):
            known[few] = exact_sky(self._sides, first + few, *self._candidates(first + few, 0.0, True))
        return known

    def _measured(self, first, last, limit, all_pairs):
        """The pairs of these rows that segments measure."""
        sides = self._sides
        found = []
        step = max(1, _PAIRS // len(sides) // 4)
        for low in range(first, last, step):
            row, column = self._candidates(np.arange(low, min(low + step, last)), limit, all_pairs)
            factor = exchange_areas(sides.vertices[row], sides.vertices[column]) / sides.area[row]
            large = np.flatnonzero(factor > limit)
            found.append((row[large], column[large], factor[large]))
        row, column, factor = (np.concatenate(part) for part in zip(*found, strict=True))
        share, error = visible_shares(sides, self._caster, row, column, factor, limit=limit,
                                      seed=int(mix(self._seed, _SEGMENTS)))
        return {"row": row, "column": column, "factor": factor * share, "error": factor * error}

    def _candidates(self, rows, limit, all_pairs):
        """The pairs of rows and columns that these rows measure and whose factor may exceed the limit."""
        sides = self._sides
        return candidates(rows, sides.centre, sides.normal, sides.radius, sides.area, limit, all_pairs)


def _sky_patches(sky, counts, rays):
    """Each row's share of the sky divided by its counts, and the standard errors, as csr_arrays of one pattern."""
    row, column = np.nonzero(counts)
    scale = sky[row] / counts.sum(axis=1)[row]
    return (sparse.csr_array((values, (row, column)), shape=counts.shape) for values in (
        scale * counts[row, column], scale * rays[row] * patch_errors(counts, rays)[row, column]))
