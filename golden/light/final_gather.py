"""Indirect light at points that are seen: interpolated, and gathered by rays beside bodies."""

import numpy as np

from golden.base.compiled import compiled
from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Rays
from golden.light.direct import DirectLight
from golden.light.form_factors import ray_ends
from golden.light.glass import Glass
from golden.light.in_flight import InFlight
from golden.light.indirect import IndirectLight
from golden.light.node_rows import joined
from golden.light.sampling import mix, sobol, uniform
from golden.light.surface_points import SurfacePoints, bilinear
from golden.light.tally import Tally
from golden.scene.scene import Scene

__all__ = ["FinalGather"]

# A ray that ends within this share of an element's length takes the light at its very end.
REACH = 0.5
# So many rays find whether light nearby changes that of a node by more than this share of it.
PROBES, CHANGED = 32, 0.05
# Integer weights of the rays of a point sum to 2^32 or just below it.
WEIGHT_BITS = 32


class FinalGather:
    """The indirect light at points: interpolated from nodes, or beside `Contacts` gathered by rays.

    The rays' directions are spread by the cosine, or are those of a small hemisphere, turned about its normal by a
    random angle. A ray that ends nearby takes the light at its very end: the element is too coarse there. Others take
    the radiosity of the piece of an element that they hit.

    Parameters
    ----------
    scene, indirect
        The patches, and the light of their elements.
    caster
        Casts the rays.
    tally
        Counts the rays, as kind ``"gather"``, or beside frusta ``"single gather"``, and their shadow rays.
    samples
        Rays per point, a power of two from 16 on.
    frusta
        As `DirectLight` takes it.
    reach
        Shares of an element's length within which a ray that ends there takes the light at its very end.
    together
        Of so many points of one hash, with ranks from a multiple on, those on one side of a patch have the light of the
        first one, at which ``frusta`` cast a hemisphere. Default: each has its own, by rays of ``caster``.
    in_flight
        As `DirectLight` takes it.
    """

    def __init__(self, scene: Scene, indirect: IndirectLight, caster, tally: Tally, samples: int, frusta=None,
                 reach: float = REACH, together: int | None = None, in_flight: InFlight | None = None):
        self._scene, self._indirect, self._samples, self._together = scene, indirect, samples, together
        if together is None:
            self._caster = tally.counting("gather" if frusta is None else "single gather", caster)
            self._cast = self._by_rays
        else:
            self._caster, self._cast = tally.counting("gather", frusta), self._by_hemispheres
        in_flight = in_flight or InFlight.of(None, shares=frusta is not None)
        self._light = DirectLight(scene, caster, tally, 1, frusta=frusta, in_flight=in_flight)
        self._most = in_flight.gather
        # What reflects nothing needs no light; mirrors diffuse what they throw of lights without an area.
        diffuses = (indirect.reflectance > 0).any(axis=1)
        if scene.lights:
            diffuses |= Glass(scene).mirrors[indirect.elements.patch]
        self._reach = reach * np.sqrt(indirect.elements.area) * diffuses

    def light(self, points: SurfacePoints, u: np.ndarray, v: np.ndarray, front: np.ndarray, keys: np.ndarray,
              rank: np.ndarray) -> np.ndarray:
        """Irradiance over pi at M points, M x 3, without light that comes straight from light sources.

        Parameters
        ----------
        u, v, front
            Their bilinear coordinates on their patches, and whether they are on the fronts.
        keys, rank
            As `DirectLight.irradiance` takes them.
        """
        result = self._indirect.at(points.patch, u, v, front)
        touched = np.flatnonzero(self._indirect.touched(points.patch, u, v, front))
        first, group = self._groups(keys[touched], rank[touched], points.patch[touched], front[touched])
        gathered, chosen = np.empty((len(first), 3)), touched[first]
        size = max(1, self._most // self._samples)
        for start in range(0, len(chosen), size):
            rows = chosen[start:start + size]
            gathered[start:start + size] = self._gathered(points[rows], keys[rows], rank[rows], self._samples)
        result[touched] = gathered[group]
        return result

    def _groups(self, keys, rank, patch, front):
        """The first ones of points that share light, and for each point the number of its group."""
        if self._together is None:
            return (np.arange(len(rank)),) * 2
        alike = np.column_stack([keys.view(np.int64), rank // self._together, patch, front])
        return np.unique(alike, axis=0, return_index=True, return_inverse=True)[1:]

    def corrected(self, seed: int) -> IndirectLight:
        """The indirect light, at nodes of flat surfaces with the light that changes within elements nearby.

        The irradiance of a node takes the light of pieces as if it were the same all over each: beside a surface that
        is half in shadow a node would be too bright, or too dark.
        """
        curved = np.unique(self._scene.surface[self._scene.is_curved])
        changes = []
        indirect = self._indirect
        for use, (nodes, irradiance) in enumerate(((indirect.elements.lattice, indirect.irradiance),
                                                   (indirect.refined, indirect.refined_irradiance))):
            flat = np.flatnonzero(~np.isin(nodes.source, curved))
            probed = self._changes(nodes.points[flat], mix(seed, 9, use, flat), PROBES, indirect.uneven)
            some = flat[np.abs(probed.mean(axis=1)) > CHANGED * irradiance[flat].mean(axis=1)]
            change = np.zeros((len(nodes), 3))
            change[some] = self._changes(nodes.points[some], mix(seed, 10, use, some), self._samples, indirect.uneven)
            changes.append(change)
        return self._indirect.changed(*changes)

    def correction(self, points: SurfacePoints, keys: np.ndarray) -> np.ndarray:
        """What to add to irradiance over pi from elements alone, M x 3, as light changes within those nearby."""
        return self._changes(points, keys, self._samples, np.ones(len(self._indirect.pieces), dtype=bool))

    def _changes(self, points, keys, samples, changing):
        """That of pieces that are ``changing``, P bool, by so many rays of a point."""
        result, rank = np.zeros((len(points), 3)), np.zeros(len(points), dtype=np.int64)
        size = max(1, InFlight().gather // samples)
        for start in range(0, len(points), size):
            rows = slice(start, start + size)
            result[rows] = self._gathered(points[rows], keys[rows], rank[rows], samples, changing)
        return result

    def _gathered(self, points, keys, rank, samples, changing=None):
        """The light of all that rays meet, or its change within pieces that are ``changing`` alone."""
        count, owner = len(points), np.repeat(np.arange(len(points)), samples)
        weight, direction, hits = self._cast(points, keys, rank, samples, owner)
        rays = Rays(points.position[owner], direction, points.sources(self._scene)[owner])
        hits = hits(rays)
        rows, found = self._indirect.rows, []
        for clear in rows.clear:
            light = np.zeros((count, 3))

            def see(owner, weight, radiance, light=light):
                light += np.stack([np.bincount(owner, weight * channel, count) for channel in radiance.T], axis=1)

            def see_sky(owner, weight, direction, see=see):
                see(owner, weight, self._scene.background_along(direction))

            outside = (see_sky, see) if changing is None else (lambda *_: None,) * 2
            for end, part, along, met in ray_ends(owner, weight, rays, hits, clear, *outside):
                piece = self._indirect.pieces.seen(along, met)
                radiance = self._change(piece, met, keys[end], rank[end] * samples + self._numbers(end), changing)
                if changing is None:
                    radiance += np.where(piece[:, None] >= 0, self._indirect.display[piece], 0.0)
                see(end, part, radiance)
            found.append(light / weight[:samples].sum())
        return joined(rows.groups, found)

    def _by_rays(self, points, keys, rank, samples, _):
        """Weights and directions of the rays of points, and the function from them to their hits."""
        direction = np.empty((len(points) * samples, 3))
        _spread(sobol(keys, samples, rank).reshape(-1, 2), frame(points.normal), samples, direction)
        return np.full(len(direction), 2**WEIGHT_BITS // samples), direction, self._caster.nearest

    def _by_hemispheres(self, points, keys, rank, samples, owner):
        """The same of a hemisphere at each point."""
        polars = max(4, 1 << (samples.bit_length() - 2) // 2)
        grid = Hemisphere(samples // polars, polars)
        turn = 2 * np.pi * uniform(mix(keys, 11), rank)
        cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
        first, second, normal = frame(points.normal).swapaxes(0, 1)
        frames = np.stack([cosine * first + sine * second, cosine * second - sine * first, normal], axis=1)
        cast = self._caster.hemispheres(grid, points.position, frames, points.sources(self._scene))
        number = np.tile(np.arange(samples), len(points))
        direction = np.einsum("rx,kxy->kry", grid.directions, frames).reshape(-1, 3)
        return np.tile(grid.weights, len(points)), direction, lambda rays: cast(owner, number, rays)

    def _change(self, piece, hits, keys, rank, changing):
        """By how much the radiance of what rays hit nearby, K x 3, differs from that of its piece."""
        elements, indirect = self._indirect.elements, self._indirect
        element = np.where(piece >= 0, indirect.pieces.element[piece], -1)
        near = np.flatnonzero((element >= 0) & (hits.t < self._reach[element]))
        near = near if changing is None else near[changing[piece[near]]]
        own, patch, u, v = element[near], hits.patch[near], hits.u[near], hits.v[near]
        points = SurfacePoints(bilinear(self._scene.vertices[patch], u, v), elements.normal[own], patch)
        arriving = self._light.irradiance(points, mix(keys[near], 8), rank[near])
        arriving += indirect.at(patch, u, v, elements.front[own])
        change = np.zeros((len(hits.t), 3))
        change[near] = (indirect.reflectance[own] * arriving + self._light.thrown(points)
                        - indirect.display[piece[near]])
        return change

    @staticmethod
    def _numbers(owner):
        """Numbers of rays among those of equal owners, which follow one another."""
        starts = np.flatnonzero(np.concatenate([[True], owner[1:] != owner[:-1]])[:len(owner)])
        return np.arange(len(owner)) - np.repeat(starts, np.diff(np.append(starts, len(owner))))


@compiled
def _spread(places, frames, samples, direction):
    """Writes directions by the cosine for points of the unit square."""
    for ray in range(len(places)):
        axes = frames[ray // samples]
        radius, angle = np.sqrt(places[ray, 0]), 2 * np.pi * places[ray, 1]
        x, y, z = radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - places[ray, 0])
        for axis in range(3):
            direction[ray, axis] = x * axes[0, axis] + y * axes[1, axis] + z * axes[2, axis]
