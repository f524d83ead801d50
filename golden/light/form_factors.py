"""Form factors by casting hemispheres of rays, with visibility."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy import sparse

from golden.base.compiled import compiled
from golden.base.errors import InputError
from golden.base.progress_bar import progress_bar
from golden.base.spread import Spread, in_turn, spans
from golden.cast.density import Density
from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Hits, Rays
from golden.light.glass import SHEETS, ClearRays
from golden.scene.scene import Scene

__all__ = ["HemisphereSums", "PatchRows", "gauss_points", "hemisphere_sums", "patch_columns", "ray_ends"]

# Rays per block, which bounds memory.
_BLOCK = 1 << 16


@dataclass(frozen=True, kw_only=True, eq=False)
class HemisphereSums:
    """Sums of M hemispheres, in integers.

    Parameters
    ----------
    weights
        Sparse M x C int64: sum of the weights of the rays of each column.
    row_sums
        M int64: sum of the weights of all rays that hit anything; 2^``weight_bits`` exactly in a closed scene. It
        exceeds the row of ``weights`` by the rays without a column (backs of one-sided patches).
    weight_bits
        W: the weights are in units of 2^-W.
    rays
        M int64: rays of each hemisphere, with those that finer ones replace.
    light
        M x 3 float64: sum of the weights times the radiance of the sky, if it is summed, of all rays that hit nothing,
        and times that of the lamps that mirrors show.
    """

    weights: sparse.csr_array
    row_sums: np.ndarray
    weight_bits: int
    rays: np.ndarray
    light: np.ndarray


def patch_columns(scene: Scene) -> Callable[[np.ndarray, Hits], np.ndarray]:
    """Columns of rays: the patch that a ray hit, or -1 where it hit nothing or the back of a one-sided patch."""

    def column_of(direction: np.ndarray, hits: Hits) -> np.ndarray:
        cosine = np.einsum("ri,ri->r", direction, scene.normals[hits.patch])
        # Patch -1, where nothing was hit, is its own column.
        return np.where((cosine < 0) | scene.two_sided[hits.patch], hits.patch, -1)

    return column_of


def hemisphere_sums(caster, hemisphere: Hemisphere, points, normals, surfaces, *, columns: int,
                    column_of: Callable[[np.ndarray, Hits], np.ndarray], clear: ClearRays | None = None,
                    sky: Callable[[np.ndarray], np.ndarray] | None = None, density: Density | None = None,
                    spread: Spread = in_turn, progress: bool = False) -> HemisphereSums:
    """Cast a hemisphere from each of M points and sum the weights of its rays by column.

    Parameters
    ----------
    caster
        A caster of frusta, see `golden.cast.ray_frusta.RayFrusta`.
    hemisphere
        The grid of rays.
    points, normals
        M x 3 positions and unit normals.
    surfaces
        M int: the surface of each point (which its rays never hit), or -1.
    columns
        Number of columns C.
    column_of
        Function from K x 3 directions of rays and their hits to columns below C, or -1 for rays without a column, such
        as those that hit nothing. `patch_columns` uses the patch; another may distinguish sides or elements of a patch.
    clear
        Follows rays through clear patches and from mirrors: the weight that goes on belongs to what is behind. Default:
        all patches end rays.
    sky
        Function from K x 3 directions to K x 3 radiances, for rays that hit nothing. Default: none is summed.
    density
        Where rays are cast again, finer, by a caster in fixed point: ``weight_bits`` grow by `Density.depth`. Default:
        nowhere.
    spread
        Casts spans of the hemispheres. Default: one after the other.
    progress
        Shows a progress bar after two seconds.
    """
    points, normals = (np.asarray(value, dtype=np.float64).reshape(-1, 3) for value in (points, normals))
    count, size = len(points), len(hemisphere)
    surfaces = np.broadcast_to(np.asarray(surfaces, dtype=np.int32), (count,))
    work = _Hemispheres(caster, hemisphere, points, frame(normals), surfaces, columns, column_of, clear, sky,
                       density)
    parts = spans(count, max(1, _BLOCK // size))
    found = {}
    with progress_bar(total=count * size, desc="form factors", unit="ray", unit_scale=True, delay=2,
                      disable=not progress) as bar:
        for (first, last), part in spread(work.sums, parts):
            found[first] = part
            bar.update((last - first) * size)
    # In the order of the hemispheres, whichever ended first; what is joined is dropped, as it takes much memory.
    ordered = [found.pop(first) for first, _ in parts]
    row_sums, light, entries, column, weight, rays = (
        np.concatenate([empty, *(part.pop(0) for part in ordered)]) for empty in (
            np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int32),
            np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)))
    weights = sparse.csr_array((weight, column, np.cumsum(entries)), shape=(count, columns))
    return HemisphereSums(weights=weights, row_sums=row_sums, rays=rays, light=light,
                          weight_bits=hemisphere.weight_bits + (density.depth(hemisphere) if density else 0))


class _Hemispheres:
    """Hemispheres of M points, with the parameters of `hemisphere_sums`."""

    def __init__(self, caster, hemisphere, points, frames, surfaces, columns, column_of, clear, sky, density):
        self._density = density
        self._caster, self._hemisphere = caster, hemisphere
        self._points, self._frames, self._surfaces = points, frames, surfaces
        self._columns, self._column_of, self._clear, self._sky = columns, column_of, clear, sky

    @cached_property
    def _cast(self):
        """Made of all points, by which casters in fixed point choose their coordinates."""
        return self._caster.hemispheres(self._hemisphere, self._points, self._frames, self._surfaces)

    @cached_property
    def _dense(self):
        return self._caster.dense_hemispheres(self._density, self._hemisphere, self._points, self._frames,
                                              self._surfaces)

    def sums(self, begin, end):
        """Of the hemispheres ``begin`` to ``end`` - 1 row sums, light, entries of rows, columns, weights, and rays."""
        row_sums, light, parts = np.zeros(end - begin, dtype=np.int64), np.zeros((end - begin, 3)), []
        counts = np.full(end - begin, len(self._hemisphere))

        def see(owner, weight, radiance):
            if not len(owner):
                return
            low, high = owner[0], owner[-1] + 1
            light[low - begin:high - begin] += np.stack(
                [np.bincount(owner - low, channel, high - low) for channel in weight * radiance.T], axis=1)

        def see_sky(owner, weight, direction):
            if self._sky is not None and len(owner):
                see(owner, weight, self._sky(direction))

        for sample, weights, rays, hits in self._blocks(begin, end, counts):
            low, high = sample[0], sample[-1] + 1
            for owner, weight, direction, met in ray_ends(sample, weights, rays, hits, self._clear, see_sky, see):
                # Sums of integers below 2^53 are exact in float64, for which bincount is fast.
                row_sums[low - begin:high - begin] += np.bincount(
                    owner - low, weight * (met.patch >= 0), high - low).astype(np.int64)
                parts.append(_entries(owner, weight, self._column_of(direction, met), self._columns))
        data, row, column = (np.concatenate(part) for part in zip(*parts, strict=True))
        rows = sparse.coo_array((data, (row - begin, column)), shape=(end - begin, self._columns)).tocsr()
        return [row_sums, light, np.diff(rows.indptr), rows.indices.astype(np.int32, copy=False), rows.data, counts]

    def _blocks(self, begin, end, counts):
        """Samples, weights, rays and hits of the hemispheres in blocks; writes how many rays finer ones have cast."""
        hemisphere, size = self._hemisphere, len(self._hemisphere)
        if self._density:
            for sample in range(begin, end):
                weights, rays, hits, counts[sample - begin] = self._dense(sample)
                yield np.full(len(weights), sample), weights, rays, hits
            return
        for first in range(begin * size, end * size, _BLOCK):
            sample, ray = np.divmod(np.arange(first, min(first + _BLOCK, end * size)), size)
            rays = _hemisphere_rays(hemisphere, self._points, self._frames, self._surfaces, sample, ray)
            yield sample, hemisphere.weights[ray], rays, self._cast(sample, ray, rays)


def gauss_points(scene: Scene, order: int) -> tuple[np.ndarray, np.ndarray]:
    """``order`` x ``order`` Gauss points on each patch and their shares of its area.

    Quadrilaterals: Gauss-Legendre in both bilinear coordinates, weighted by the local area. Triangles: Gauss-Jacobi in
    v, which ends at the repeated vertex; its weights include the local area.

    Parameters
    ----------
    order
        Points along a side, 1 to 16; 1 is the middle of a patch.

    Returns
    -------
    N x order^2 x 3 points and N x order^2 shares, which sum to 1 for each patch.

    Raises
    ------
    InputError
        The order is out of range.
    """
    if not isinstance(order, (int, np.integer)) or isinstance(order, bool) or not 1 <= order <= 16:
        raise InputError(f"form factors: Samples must be 1 to 16 along a side, not {order!r}", parameter="samples")
    from scipy.special import roots_jacobi  # slow

    knots, gauss = leggauss(order)
    falling, jacobi = roots_jacobi(order, 1, 0)
    points, shares = np.empty((len(scene), order**2, 3)), np.empty((len(scene), order**2))
    for which, v_knots, v_gauss in ((~scene.is_triangle, knots, gauss), (scene.is_triangle, falling, jacobi)):
        u, v = (grid.ravel() / 2 + 0.5 for grid in np.meshgrid(knots, v_knots, indexing="ij"))
        corner = scene.vertices[which]
        bilinear = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
        points[which] = np.einsum("qk,nkx->nqx", bilinear, corner)
        shares[which] = np.outer(gauss, v_gauss).ravel()
    quads = np.flatnonzero(~scene.is_triangle)
    shares[quads] *= _local_area(scene.vertices[quads], knots / 2 + 0.5)
    return points, shares / shares.sum(axis=1, keepdims=True)


class PatchRows:
    """Rows of the form factors of a scene's patches, cast on demand.

    Parameters
    ----------
    scene, caster
        The patches, and a caster of frusta.
    rays
        (azimuths, polars) of the hemispheres.
    samples
        Gauss points along each side of a patch.
    density
        See `hemisphere_sums`.
    progress
        Shows a progress bar after two seconds.

    Members
    -------
    weight_bits
        Row sums are in units of 2^-weight_bits.

    Raises
    ------
    InputError
        Rays or samples out of range.
    """

    def __init__(self, scene: Scene, caster, *, rays: tuple[int, int], samples: int = 1,
                 density: Density | None = None, progress: bool = False):
        self._scene, self._caster, self._density, self._progress = scene, caster, density, progress
        self.hemisphere = Hemisphere(*rays)
        self.weight_bits = self.hemisphere.weight_bits + (density.depth(self.hemisphere) if density else 0)
        self._points, self._shares = gauss_points(scene, samples)

    def cast(self, patches) -> tuple[sparse.csr_array, np.ndarray, np.ndarray]:
        """Form factors from k patches to all, sparse k x N float64; row sums and rays, k x samples int64 each."""
        patches, samples = np.asarray(patches), self._shares.shape[1]
        owner = np.repeat(patches, samples)
        sums = hemisphere_sums(self._caster, self.hemisphere, self._points[patches], self._scene.normals[owner],
                               self._scene.surface[owner], columns=len(self._scene),
                               column_of=patch_columns(self._scene), density=self._density, progress=self._progress)
        share = self._shares[patches].ravel() / 2**sums.weight_bits
        blocks = np.arange(0, len(patches) * samples + 1, samples)
        mean = sparse.csr_array((share, np.arange(len(share)), blocks), shape=(len(patches), len(share)))
        return (mean @ sums.weights).tocsr(), sums.row_sums.reshape(-1, samples), sums.rays.reshape(-1, samples)

    def rows(self, patches) -> sparse.csr_array:
        """Form factors from k patches to all, k x N."""
        return self.cast(patches)[0]


def _hemisphere_rays(hemisphere, points, frames, surfaces, sample, ray):
    """One ray for each pair of a sample and a direction."""
    direction = np.empty((len(ray), 3))
    _rotate(hemisphere.directions, frames, ray, sample, direction)
    return Rays(points[sample], direction, source=surfaces[sample])


@compiled
def _rotate(local, frames, ray, sample, direction):
    for row in range(len(ray)):
        x, y, z = local[ray[row]]
        axes = frames[sample[row]]
        for axis in range(3):
            direction[row, axis] = x * axes[0, axis] + y * axes[1, axis] + z * axes[2, axis]


def _entries(owner, weight, column, columns):
    """Sums of integers by owner, ascending, and column, of those that have one: the sums, their owners and columns.

    Columns of an owner are in any order.
    """
    total, row, met = np.empty((3, len(owner)), dtype=np.int64)
    count = _sum_by_column(owner, weight, column, np.zeros(columns, dtype=np.int64), total, row, met)
    return total[:count].copy(), row[:count].copy(), met[:count].copy()


@compiled
def _sum_by_column(owner, weight, column, sums, total, row, met):
    """Writes the sums, owner by owner, and returns their number; ``sums`` is 0, before and after."""
    first = end = 0
    for k in range(len(owner)):
        if column[k] >= 0 and weight[k] > 0:
            if sums[column[k]] == 0:
                met[end] = column[k]
                end += 1
            sums[column[k]] += weight[k]
        if k + 1 == len(owner) or owner[k + 1] != owner[k]:
            for place in range(first, end):
                total[place], row[place] = sums[met[place]], owner[k]
                sums[met[place]] = 0
            first = end
    return end


def ray_ends(sample, weight, rays, hits, clear, see_sky, see):
    """Yields samples in ascending order, weights that end there, directions and hits of rays; then of those that went
    on, and so on. The last ones include those that hit nothing.

    ``see_sky`` takes the samples, weights and directions of those that hit nothing; ``see`` samples, weights and
    radiances of those that show a lamp in a mirror, which shadow rays do not find.
    """
    onward = 0 if clear is None else SHEETS
    waves = [(sample, weight, rays, hits, np.zeros(len(sample), dtype=bool))]
    for left in range(onward, -1, -1):
        later = []
        for sample, weight, rays, hits, mirrored in waves:
            missed, met = np.flatnonzero(hits.patch < 0), np.flatnonzero(hits.patch >= 0)
            see_sky(sample[missed], weight[missed], rays.direction[missed])
            shown = met[mirrored[met]]
            if len(shown):
                see(sample[shown], weight[shown], clear.emission(rays[shown], _at(hits, shown)))
            if not left:
                yield sample, weight, rays.direction, hits
                continue
            sample, weight, rays, hits, mirrored = sample[met], weight[met], rays[met], _at(hits, met), mirrored[met]
            passed = clear.passed(rays, hits, weight, mirrored)
            # Both are rounded: together they may exceed the weight by one.
            thrown = np.minimum(clear.thrown(rays, hits, weight, mirrored), weight - passed)
            yield sample, weight - passed - thrown, rays.direction, hits
            for part, follow, is_mirror in ((passed, clear.behind, False), (thrown, clear.from_mirror, True)):
                going = np.flatnonzero(part)
                if len(going):
                    later.append((sample[going], part[going], *follow(rays[going], _at(hits, going)),
                                  mirrored[going] | is_mirror))
        waves = later


def _at(hits, rows):
    return Hits(**{name: value[rows] for name, value in vars(hits).items()})


def _local_area(corner, knots):
    """Area per unit of u and v at the knots of each quadrilateral, N x order^2."""
    u, v = (grid.ravel() for grid in np.meshgrid(knots, knots, indexing="ij"))
    along_u = np.einsum("q,nx->nqx", 1 - v, corner[:, 1] - corner[:, 0]) + \
        np.einsum("q,nx->nqx", v, corner[:, 2] - corner[:, 3])
    along_v = np.einsum("q,nx->nqx", 1 - u, corner[:, 3] - corner[:, 0]) + \
        np.einsum("q,nx->nqx", u, corner[:, 2] - corner[:, 1])
    return np.linalg.norm(np.cross(along_u, along_v), axis=2)
