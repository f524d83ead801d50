"""Direct light: irradiance from the lights at a point, by shadow rays."""

import numpy as np

from golden.base.compiled import compiled
from golden.cast.rays import Rays
from golden.cast.shadow_rays import ShadowRays
from golden.light.glass import SHEETS, Glass
from golden.light.in_flight import InFlight
from golden.light.light_choice import choose_lights
from golden.light.light_points import by_area, net, net_points
from golden.light.light_weights import light_weights
from golden.light.sampling import sobol
from golden.light.solid_angle import direction_to_triangle, solid_angle
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.lights import PointLight
from golden.scene.scene import Scene

__all__ = ["DirectLight"]

# A shadow ray ends this share of its length before its light, so that the light does not shadow itself.
SHORT_OF_LIGHT = 1 - 1e-6
# Lights nearer than this many of their radii are sampled uniformly by solid angle: sampling by area has unbounded
# variance for a light that touches a surface. Below the solid angle LEAST rounding forbids it.
NEAR, LEAST = 3, 1e-7
# As NEAR, where shadow rays share points of lights.
NEAR_SHARED = 1
# A light has 4^n points that shadow rays share: at least as many as a shaded point casts rays, and so many that about
# EACH rays share one; n is in the range SHARED.
EACH, SHARED = 4096, (2, 8)


class DirectLight:
    """Irradiance from the area lights (patches whose material emits) and the lights without an area of a scene.

    Each point casts ``samples`` shadow rays to its area lights. Lights are chosen in proportion to their estimated
    unoccluded irradiance, by one number of a low-discrepancy pair; rescaled, the same number selects the position on
    the light (by solid angle on a near one), so a single light is stratified. Transparent patches attenuate a shadow
    ray as `Glass` says and do not refract it.

    A caster of frusta casts the rays of many points to a few points of each light together. Their positions on a light
    are those of a net (`golden.light.light_points.net`), and rays that are too few for a frustum go to ``caster``.

    Parameters
    ----------
    scene
        Patches and lights.
    caster
        Casts the shadow rays.
    tally
        Counts the shadow rays, as kind ``"shadow"``; those that are cast singly beside frusta as ``"single shadow"``.
    samples
        Shadow rays to area lights per point, at least 1.
    frusta
        Caster of frusta with ``shadows``, or None.
    rays
        About so many shadow rays will be cast in all.
    in_flight
        How many rays are cast at once. Default: as many as without a bound of memory.
    """

    def __init__(self, scene: Scene, caster, tally: Tally, samples: int, *, frusta=None, rays: int = 0,
                 in_flight: InFlight | None = None):
        self._scene, self._samples = scene, samples
        self._most = (in_flight or InFlight.of(None, shares=frusta is not None)).shadow
        self._caster = tally.counting("shadow" if frusta is None else "single shadow", caster)
        self._frusta = None if frusta is None else tally.counting("shadow", frusta)
        emission = scene.channels("emission")
        self._lights = np.flatnonzero(emission.max(axis=1) > 0)
        self._emission = emission[self._lights]
        self._vertices, self._is_triangle = scene.vertices[self._lights], scene.is_triangle[self._lights]
        self._centre, self._front = scene.centres[self._lights], scene.normals[self._lights]
        self._two_sided = scene.two_sided[self._lights]
        self._radius2 = ((self._vertices - self._centre[:, None]) ** 2).sum(axis=2).max(axis=1)
        self._power = self._emission.mean(axis=1) * scene.areas[self._lights]
        self._glass = Glass(scene)
        if frusta is not None:
            self._share_points(rays)

    def _share_points(self, rays):
        """Choose the points of lights that shadow rays share; lights without an area are such points."""
        by_rays = np.floor(np.log2(max(1, rays // EACH // max(1, len(self._lights)))) / 2)
        self._bits = int(np.clip(max(np.ceil(np.log2(self._samples) / 2), by_rays), *SHARED))
        on_lights = [net_points(self._vertices, self._is_triangle, self._bits)] if len(self._lights) else []
        lights = [light.position for light in self._scene.lights if isinstance(light, PointLight)]
        self._points = np.concatenate([*on_lights, np.reshape(lights, (-1, 3))])
        self._surfaces = np.full(len(self._points), -1)
        of_areas = np.repeat(self._scene.surface[self._lights], 4**self._bits)
        self._surfaces[:len(of_areas)] = of_areas

    def irradiance(self, points: SurfacePoints, keys: np.ndarray,
                   rank: np.ndarray | None = None) -> np.ndarray:
        """Irradiance over pi at M points, M x 3, in units of radiance: reflectance times it is the reflected radiance.

        Parameters
        ----------
        keys
            M hashes (`golden.light.sampling.mix`), one per point, that seed the samples.
        rank
            Points of one hash and neighbouring ranks have samples that spread over the lights together, see
            `golden.light.sampling.sobol`. Default: each point has a hash of its own.
        """
        rank = np.zeros(len(points), dtype=np.int64) if rank is None else rank
        result = np.zeros((len(points), 3))
        block = max(1, self._most // max(len(self._lights), self._samples))
        for start in range(0, len(points), block):
            rows = slice(start, start + block)
            if len(self._lights):
                result[rows] += self._from_areas(points[rows], keys[rows], rank[rows])
            self._add_lights(result[rows], points[rows])
        return result

    def thrown(self, points: SurfacePoints) -> np.ndarray:
        """What flat mirrors throw of the lights without an area, which hemispheres do not meet: it diffuses.

        M x 3, as the radiance of what rays do not throw further there; 0 at points that are on no flat mirror.
        """
        result = np.zeros((len(points), 3))
        rows = np.flatnonzero(self._glass.mirrors[points.patch])
        if len(rows) and self._scene.lights:
            share, lit = self._glass.mean_thrown[points.patch[rows]], np.zeros((len(rows), 3))
            self._add_lights(lit, points[rows])
            result[rows] = share / (1 - share) * lit
        return result

    def _add_lights(self, result, points):
        number = 0
        for light in self._scene.lights:
            if isinstance(light, PointLight):
                result += self._from_point(points, light, number)
                number += 1
            else:
                result += self._from_afar(points, light)

    def _from_areas(self, points, keys, rank):
        weight = light_weights(points.position, points.normal, self._vertices, self._centre, self._front,
                               self._two_sided, self._power, self._radius2)
        places = sobol(keys, self._samples, rank)
        sample, choice, u, density = choose_lights(weight, places[..., 0])
        where, v = sample // self._samples, places[..., 1].ravel()[sample]
        toward, angle, shared = self._sample(points.position[where], choice, u, v)
        geometry = np.empty(len(where))
        _cosines(points.normal, where, toward, geometry)
        geometry *= angle / (np.pi * density)
        some = np.flatnonzero(geometry > 0)
        light = self._emission[choice[some]] * geometry[some, None]
        light *= self._visibility(points, where[some], toward[some], SHORT_OF_LIGHT, shared[some])
        row = where[some]
        return np.stack([np.bincount(row, light[:, channel], len(points)) for channel in range(3)],
                        axis=1) / self._samples

    def _sample(self, origin, choice, u, v):
        """Vectors to points at (u, v) of the unit square on the chosen lights, and solid angle per unit square.

        Also the number of the shared point, or -1.
        """
        toward, measure, near = np.empty((len(choice), 3)), np.empty(len(choice)), NEAR
        shared, x, y = np.full(len(choice), -1), u, v
        if self._frusta is not None:
            number, x, y = net(u, v, self._bits)
            shared, near = (choice << 2 * self._bits) + number, NEAR_SHARED
        by_area(self._vertices, self._is_triangle, choice, origin, x, y, toward, measure)
        close = np.flatnonzero(((self._centre[choice] - origin) ** 2).sum(axis=1) < near**2 * self._radius2[choice])
        halves = (self._vertices[choice[close]] - origin[close, None])[:, [[0, 1, 2], [0, 2, 3]]]
        angles = solid_angle(halves.reshape(-1, 3, 3)).reshape(-1, 2)
        near = angles.sum(axis=1) > LEAST
        rows, angles = close[near], angles[near]
        normal = self._scene.normals[self._lights[choice[rows]]]
        toward[rows], measure[rows] = _by_angle(halves[near], angles, normal, u[rows], v[rows]), angles.sum(axis=1)
        shared[rows] = -1
        return toward, measure, shared

    def _from_point(self, points, light, number):
        toward = np.asarray(light.position) - points.position
        distance2 = np.einsum("kj,kj->k", toward, toward)
        cosine = np.einsum("kj,kj->k", points.normal, toward)
        some = np.flatnonzero((cosine > 0) & (distance2 > 0))
        share = cosine[some] / (np.pi * distance2[some] ** 1.5)
        for shape in (light.cone, light.web):
            if shape is not None:
                share *= shape.factor(toward[some])
                some, share = some[share > 0], share[share > 0]
        result = np.zeros((len(points), 3))
        shared = np.full(len(some), -1)
        if self._frusta is not None:
            shared[:] = (len(self._lights) << 2 * self._bits) + number
        result[some] = share[:, None] * light.intensity * self._visibility(points, some, toward[some], 1.0, shared)
        return result

    def _from_afar(self, points, light):
        toward = -np.asarray(light.direction) / np.linalg.norm(light.direction)
        cosine = points.normal @ toward
        some = np.flatnonzero(cosine > 0)
        result = np.zeros((len(points), 3))
        result[some] = cosine[some, None] / np.pi * light.irradiance * self._visibility(
            points, some, np.tile(toward, (len(some), 1)), np.inf, np.full(len(some), -1))
        return result

    def _visibility(self, points, row, toward, tmax, shared):
        """Transmitted share of light, M x 3, along ``toward`` to the points numbered ``row``.

        ``shared`` has the numbers of the points of lights that the rays share, or -1.
        """
        through = np.ones((len(row), 3))
        going = np.arange(len(row)) if self._frusta is None else self._left_by_frusta(through, points, row, shared)
        rays = Rays(points.position[row[going]], toward[going], points.sources(self._scene)[row[going]],
                    np.full(len(going), tmax))
        if not self._glass.clear.any():
            blocked = self._caster.any_hit(rays).patch >= 0
            through[going[blocked]] = 0
            return through
        for _ in range(SHEETS + 1):
            hits = self._caster.nearest(rays)
            met = np.flatnonzero(hits.patch >= 0)
            patch, direction = hits.patch[met], rays.direction[met]
            cosine = np.abs(np.einsum("kj,kj->k", direction, self._scene.normals[patch]))
            through[going[met]] *= self._glass.passed(patch, cosine / np.linalg.norm(direction, axis=1))
            met = met[through[going[met]].max(axis=1) > 0]
            if not len(met):
                return through
            going = going[met]
            rest = rays.tmax[met] - hits.t[met]
            rays = Rays(rays.origin[met] + hits.t[met, None] * rays.direction[met], rays.direction[met],
                        self._scene.surface[hits.patch[met]], rest)
        through[going] = 0
        return through

    def _left_by_frusta(self, through, points, row, shared):
        """Cast what frusta can; the numbers of the rays that are left. Those that may pass through glass are, too."""
        of_frusta = np.flatnonzero(shared >= 0)
        patch, normals = points.patch[row[of_frusta]], points.normal[row[of_frusta]].copy()
        normals[patch >= 0] = self._scene.normals[patch[patch >= 0]]
        hits = self._frusta.shadows(ShadowRays(points=self._points, surfaces=self._surfaces, light=shared[of_frusta],
                                               targets=points.position[row[of_frusta]], normals=normals))
        through[of_frusta[hits.blocked]] = 0
        known = hits.cast if not self._glass.clear.any() else hits.cast & ~hits.blocked
        left = np.ones(len(row), dtype=bool)
        left[of_frusta[known]] = False
        through[left] = 1
        return np.flatnonzero(left)


@compiled
def _cosines(normal, where, toward, cosine):
    """Cosines of vectors above the surface at the points ``where``, or 0."""
    for k in range(len(where)):
        point = where[k]
        length = np.sqrt(toward[k, 0] * toward[k, 0] + toward[k, 1] * toward[k, 1] + toward[k, 2] * toward[k, 2])
        along = (normal[point, 0] * toward[k, 0] + normal[point, 1] * toward[k, 1] + normal[point, 2] * toward[k, 2])
        # A point on a light may sample itself.
        cosine[k] = max(along, 0.0) / length if length > 0 else 0.0


def _by_angle(halves, angles, normal, u, v):
    """Points of pairs of triangles K x 2 x 3 x 3 in a plane, uniformly over their solid angles K x 2."""
    first = angles[:, 0] / angles.sum(axis=1)
    second = u >= first
    x = np.where(second, u - first, u) / np.where(second, 1 - first, first)
    corners = halves[np.arange(len(u)), second.astype(int)]
    direction = direction_to_triangle(corners, np.clip(x, 0, 1), v)
    slope, height = np.einsum("kj,kj->k", direction, normal), np.einsum("kj,kj->k", corners[:, 0], normal)
    # Rounding must not exceed the farthest corner.
    farthest = np.linalg.norm(corners, axis=2).max(axis=1)
    distance = np.divide(height, slope, out=farthest.copy(), where=np.abs(height) < farthest * np.abs(slope))
    return distance[:, None] * direction
