"""The picture of a scene in two passes: indirect light by radiosity, all else by ray tracing."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from math import isqrt
from numbers import Real
from pathlib import Path

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import InputError, check_choice, whole_number, whole_pair
from golden.base.output import check_outputs
from golden.base.spread import in_threads, in_turn, spans
from golden.cast.density import Density
from golden.cast.hemisphere import Hemisphere
from golden.cast.methods import RAY_METHODS, check_cell, shadow_caster
from golden.cast.rays import Hits, Rays
from golden.cast.screen import Screen
from golden.cast.shared_caster import default_method, shared_caster
from golden.engine.cast.methods import FIXED_METHODS, FRUSTUM_METHODS, frustum_caster
from golden.light.direct import DirectLight
from golden.light.final_gather import FinalGather
from golden.light.glass import Glass, fresnel
from golden.light.image import write_exr, write_png
from golden.light.in_flight import MEGABYTES, InFlight
from golden.light.indirect import IndirectLight, indirect_light
from golden.light.limits import not_computed, warn_of_flush_lights, warn_of_near_lights, warn_of_tiny_patches
from golden.light.near_lights import NearPairs, near_knots
from golden.light.photometry.quantities import EFFICACY, check_efficacy, lux
from golden.light.photometry.sensor_light import sensor_light
from golden.light.photometry.sensors import Sensors
from golden.light.pixels import Pixels, PixelSums
from golden.light.preview import Preview
from golden.light.sampling import mix
from golden.light.seen_points import SeenPoints
from golden.light.solvers import SOLVERS
from golden.light.solvers.on_demand import Shooting
from golden.light.tally import Tally
from golden.light.tone import luminance, tone_map
from golden.render.render_statistics import RenderStatistics
from golden.scene.camera import Camera
from golden.scene.refine import Refinement, refine
from golden.scene.scene import Scene

__all__ = ["RenderResult", "RenderSettings", "render"]

# A mirrored or refracted ray that can change a pixel by less than this share of what it sees is dropped.
FAINT = 1 / 512
# Components of the normal of a facet and of its shading that differ by less are the same.
FLAT = 1e-12
# Grids of the hemispheres of elements and of sensors (azimuths and polars), and rays within which they stay if one can.
ELEMENT_GRIDS, ELEMENT_RAYS = ((256, 64), (128, 32), (64, 16), (32, 16)), 6_000_000
SENSOR_GRIDS, SENSOR_RAYS = ((1024, 256), (512, 128), (256, 64)), 12_000_000
# Shadow rays of an element, whose light others reflect, and of a sensor, which has no neighbours to average its noise
# with, for one of a point in the image. A sensor casts at most as many as its hemisphere has rays.
ELEMENT_SAMPLES, SENSOR_SAMPLES = 8, 1024
# Rays of a pixel that gather light beside bodies, and where a sky is part of it, which few rays meet through openings;
# at least so many of a point.
GATHER, SKY_GATHER, LEAST_GATHER = 128, 512, 16
# Rays of a node that find light which changes within elements nearby, and how near, in lengths of an element.
NODE_GATHER, NODE_REACH = 256, 2.0


@dataclass(frozen=True, kw_only=True)
class RenderSettings:
    """Settings of a render.

    Parameters
    ----------
    width, height
        Pixels, 1 to 16384 each and at most 2^26 together.
    samples
        Primary rays per pixel, a square number from 1 to 1024: one random ray in each field of a square grid, no two
        of a pixel in one of its ``samples`` columns or rows.
        With a method of `FIXED_METHODS` it passes through the field's middle.
    light_samples
        Shadow rays to area lights per shaded point, 1 to 1024; those of neighbouring pixels spread together.
    noise
        Relative standard error of a pixel above which it is cast again with four times its samples, 0.001 to 1; at
        least 4 samples are needed to see it. Default: each pixel is cast once.
    depth
        Most reflections and refractions of a ray, 0 to 64.
    rays
        (azimuths, polars) of a radiosity hemisphere. Default: 32 x 16 to 256 x 64, within 6 million rays if they can.
    least_rays
        The cells around a patch that fewer rays of a radiosity hemisphere meet are cast again, finer, see
        `golden.cast.density.Density`; with a method of `FIXED_METHODS`. Default: none are.
    elements
        The scene's area over that of the largest square element of pass 1, 1 to 10^6. Flat scenes get about so many.
    max_edge, max_area
        Largest element of pass 1 in (squared) scene units. Default: edges of at most the square root of the scene's
        area over ``elements``.
    solver
        A name of `golden.light.solvers.SOLVERS`.
    method
        A name of `FRUSTUM_METHODS`: how hemispheres and primary rays are cast. Default: grid with a ``cell``, else the
        `golden.cast.shared_caster.default_method`. Other rays are cast by the same method
        if it can, else by ``grid``; with a method of `FIXED_METHODS` shadow rays are frusta where many share a point
        of a light.
    cell
        Cell size of ``method``, if it has cells, as a share of the scene's longest side, 1/256 to 1. Default: the
        method's own.
    shooting
        Rows of the radiosity system are cast when their elements shoot, in place of ``solver``. Default: all rows are.
    seed
        Seed of all samples, at least 0.
    memory
        Megabytes that rays of the picture may take at once, in each worker, 64 to 2^20; with methods of frusta more
        rays share a frustum where they have more. Default: what `InFlight` gives without.
    jobs
        Threads that cast (see `golden.cast.grid.Grid`); the picture does not depend on it.

    Raises
    ------
    InputError
        A value out of range, or more primary rays than a method of `FIXED_METHODS` casts at once.
    """

    width: int = 512
    height: int = 512
    samples: int = 4
    light_samples: int = 2
    noise: float | None = None
    depth: int = 6
    rays: tuple[int, int] | None = None
    least_rays: int | None = None
    elements: int = 3000
    max_edge: float | None = None
    max_area: float | None = None
    solver: str = "conjugate-gradient"
    shooting: Shooting | None = None
    method: str = None  # type: ignore[assignment]  # None is replaced by what it stands for
    cell: float | None = None
    seed: int = 0
    memory: int | None = None
    jobs: int | None = None

    def __post_init__(self):
        limits = {"width": (1, 16384), "height": (1, 16384), "samples": (1, 1024), "light_samples": (1, 1024),
                  "depth": (0, 64), "elements": (1, 10**6), "seed": (0, 2**63 - 1)}
        for name, (low, high) in limits.items():
            object.__setattr__(self, name, whole_number(name.capitalize().replace("_", " "), getattr(self, name), low,
                                                        high, parameter=name))
        if self.memory is not None:
            object.__setattr__(self, "memory", whole_number("Memory", self.memory, *MEGABYTES, parameter="memory"))
        if self.rays is not None:
            object.__setattr__(self, "rays", whole_pair("Rays", self.rays, parameter="rays"))
        if self.side**2 != self.samples:
            raise InputError(f"Samples must be a square number (1, 4, 9, 16 ... 1024), not {self.samples}; the nearest "
                             f"ones are {self.side**2} and {(self.side + 1)**2}", parameter="samples")
        if self.width * self.height > 2**26:
            raise InputError(f"Size must be at most {2**26} pixels, not {self.width} x {self.height}", parameter="size")
        if self.method is None:
            object.__setattr__(self, "method", default_method() if self.cell is None else "grid")
        for name, choices in (("solver", SOLVERS), ("method", FRUSTUM_METHODS)):
            check_choice(name.capitalize(), getattr(self, name), choices, parameter=name)
        check_cell(self.method, self.cell)
        if self.shooting is not None and not isinstance(self.shooting, Shooting):
            raise InputError(f"Shooting must be a Shooting or None, not {self.shooting!r}", parameter="shooting")
        if self.noise is not None:
            self._check_noise()
        if self.least_rays is not None:
            Density(least=self.least_rays)
        if self.method in FIXED_METHODS:
            self._check_fixed()
        elif self.least_rays is not None:
            raise InputError(f"render: Least rays need a method of frusta alone ({', '.join(FIXED_METHODS)}), not "
                             f"{self.method}", parameter="least_rays")

    def _check_noise(self):
        if isinstance(self.noise, bool) or not isinstance(self.noise, Real) or not 0.001 <= self.noise <= 1:
            raise InputError(f"Noise must be 0.001 to 1, not {self.noise!r}", parameter="noise")
        if self.samples < 4:
            raise InputError(f"Samples must be at least 4 where noise is estimated, not {self.samples}",
                             parameter="samples")
        object.__setattr__(self, "noise", float(self.noise))

    def _check_fixed(self):
        from golden.engine.cast.fixed_frusta import MOST_ACROSS, MOST_RAYS  # of the machine in integers

        rays, across = self.width * self.height * self.side**2, self.side * max(self.width, self.height)
        if rays > MOST_RAYS or across > MOST_ACROSS:
            raise InputError(f"Size times samples must be at most {MOST_RAYS} rays, {MOST_ACROSS} across, by method "
                             f"{self.method}, not {rays}", parameter="size")

    @property
    def side(self) -> int:
        """A pixel has ``side`` x ``side`` fields, each with a primary ray."""
        return isqrt(self.samples)

    @property
    def density(self) -> Density | None:
        """Where hemispheres cast finer rays; None: nowhere."""
        return None if self.least_rays is None else Density(least=self.least_rays)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class RenderResult:
    """A picture and its statistics.

    Parameters
    ----------
    image
        height x width x 3 float64 radiance, linear; row 0 on top.
    tests, steps
        height x width: ray-patch tests and cell steps of the primary, reflected and refracted rays of each pixel.
    received
        height x width: luminance of the irradiance over pi of what the primary rays hit, or None.
    sensors
        S x 3: irradiance over pi at the sensors, in units of radiance, or None.
    indirect
        The light of the elements.
    stats
        Counts and seconds, ready for JSON.
    """

    image: np.ndarray
    tests: np.ndarray
    steps: np.ndarray
    received: np.ndarray | None
    sensors: np.ndarray | None
    indirect: IndirectLight
    stats: dict

    def __repr__(self) -> str:
        height, width, _ = self.image.shape
        return (f"<RenderResult: {width} x {height} pixels, {self.stats['total']['rays']} rays, "
                f"{sum(self.stats['seconds'].values()):.1f} s>")

    @property
    def statistics(self) -> RenderStatistics:
        """Counts and seconds."""
        return RenderStatistics.of(self.stats)

    def illuminance(self, efficacy: float = EFFICACY) -> np.ndarray:
        """S float64: illuminance at the sensors in lux, for ``efficacy`` in lm/W.

        Raises
        ------
        InputError
            The picture was made without sensors, or the efficacy is not finite and above 0.
        """
        if self.sensors is None:
            raise InputError("render: Sensors must be given for illuminances", parameter="sensors")
        return lux(self.sensors, efficacy)

    def pixels(self, *, exposure: float | None = None, curve: str = "reinhard", gamma: float | None = None,
               bits: int = 8) -> np.ndarray:
        """The picture for a display, see `golden.light.tone.tone_map`."""
        return tone_map(self.image, exposure=exposure, curve=curve, gamma=gamma, bits=bits)

    def save(self, path: str | Path, *, exposure: float | None = None, curve: str = "reinhard",
             gamma: float | None = None, bits: int = 8, efficacy: float = EFFICACY) -> None:
        """Write a .png as a display shows it, or an .exr of linear radiance; atomically.

        Parameters
        ----------
        exposure, curve, gamma, bits
            See `golden.light.tone.tone_map`; of a .png.
        efficacy
            Luminous efficacy in lm/W, which an .exr states.
        """
        check_efficacy(efficacy)
        path = Path(path)
        check_outputs(path, suffixes=(".png", ".exr"))
        if path.suffix.lower() == ".exr":
            write_exr(path, self.image, white=efficacy)
        else:
            write_png(path, self.pixels(exposure=exposure, curve=curve, gamma=gamma, bits=bits), gamma=gamma)


def render(scene: Scene, *, camera: Camera, settings: RenderSettings, sensors: Sensors | None = None,
           with_received: bool = False, frusta=None, workers=None, preview: Preview | None = None,
           progress: bool = False, estimate: Callable[[int, float], None] | None = None) -> RenderResult:
    """Render a scene.

    Parameters
    ----------
    scene
        The scene; it must have a light (an emitting material, a point light or a background).
    sensors
        Points at which light is measured, or None.
    with_received
        Whether the light that arrives at what a pixel shows is measured.
    frusta
        Caster of hemispheres and primary rays, see `golden.cast.ray_frusta.RayFrusta`. Default: that of the method.
    workers
        A `radiosity.workers.pool.WorkerPool` that casts the hemispheres of elements and the rays of pixels. Default:
        none.
    preview
        Draws pictures between the steps of the settings' ``shooting``. Default: none.
    progress
        Shows progress bars for steps of more than two seconds.
    estimate
        See `golden.light.indirect.indirect_light`.

    Raises
    ------
    InputError
        The scene has no light, or a setting does not fit the scene.

    Source: Shen 1993, section 2.4.
    """
    if not scene.is_lit:
        raise InputError(f"scene {scene.name!r}: it has no light: no material emits, and it has no point light and "
                         f"no background")
    _check_shooting(scene, settings, preview)
    tally = Tally()
    in_spans = settings.method in RAY_METHODS and frusta is None
    with tally.stage("cells"):
        frusta = frusta or frustum_caster(scene, settings.method, cell=settings.cell, jobs=settings.jobs,
                                          progress=progress)
        caster = frusta if settings.method in RAY_METHODS else shared_caster(
            scene, "grid", settings.jobs, progress)
    if workers:
        spread = tally.over(workers.spread(scene, frusta=frusta, rays=caster))
    else:
        # Threads share the caster, which no cast changes.
        spread = in_threads(caster.jobs) if in_spans else in_turn
    with tally.stage("elements"):
        refinement = _refinement(scene, settings, caster)
    hemisphere = Hemisphere(*(settings.rays or _hemisphere_rays(len(refinement.parent), ELEMENT_GRIDS, ELEMENT_RAYS)))
    screen = Screen(camera=camera, width=settings.width, height=settings.height)
    indirect = indirect_light(scene, refinement, frusta, caster, tally, hemisphere=hemisphere, solver=settings.solver,
                              light_samples=ELEMENT_SAMPLES * settings.light_samples, seed=settings.seed,
                              density=settings.density, shooting=settings.shooting,
                              preview=preview and preview.of(scene, screen, caster), spread=spread, progress=progress,
                              estimate=estimate)
    if not settings.shooting:
        with tally.stage("light near nodes"):
            nearby = FinalGather(scene, indirect, caster, tally, NODE_GATHER, shadow_caster(frusta), reach=NODE_REACH)
            indirect = nearby.corrected(settings.seed)
    measured = None
    if sensors is not None:
        with tally.stage("sensors"):
            around = Hemisphere(*_hemisphere_rays(len(sensors), SENSOR_GRIDS, SENSOR_RAYS))
            measured = sensor_light(
                scene, sensors, indirect, caster, tally, hemisphere=around, seed=settings.seed,
                light_samples=min(SENSOR_SAMPLES * settings.light_samples, len(around)), frusta=frusta)
    primary = tally.counting("primary", frusta)
    specular = frusta.specular(screen, settings.side) if hasattr(frusta, "specular") else None
    in_flight = InFlight.of(settings.memory, shares=shadow_caster(frusta) is not None,
                            threads=caster.jobs if in_spans and not workers else 1)
    shader = _Shader(scene, frusta, caster, tally, indirect, settings, with_received, in_flight, specular)
    with tally.stage("image"):
        found = Pixels(primary, shader, screen, settings, frusta.regular).cast(spread, in_flight.primary, progress)
    shape = screen.height, screen.width
    light = np.moveaxis((found.sums[:3] / found.rays).reshape(3, *shape), 0, 2)
    tests, steps = (found.sums[row].reshape(shape).astype(np.int64) for row in (3, 4))
    return RenderResult(image=light, tests=tests, steps=steps, sensors=measured, indirect=indirect,
                        received=(found.sums[5] / found.rays).reshape(shape) if with_received else None,
                        stats=_stats(scene, settings, hemisphere, indirect, tally, found))


def _check_shooting(scene, settings, preview):
    if preview and not settings.shooting:
        raise InputError("render: A preview needs shooting", parameter="preview")
    if settings.shooting and scene.has_sky:
        raise InputError(f"scene {scene.name!r}: It has a background, whose light hemispheres of all elements find: "
                         "rows cannot be cast on demand", parameter="shooting")
    goes_on = Glass(scene).goes_on
    if settings.shooting and goes_on.any():
        name = scene.materials[scene.material[np.argmax(goes_on)]].name
        raise InputError(f"scene {scene.name!r}: Material {name!r} is clear or mirrors, and its light goes on to where "
                         "it does not shoot: rows cannot be cast on demand", parameter="shooting")


def _refinement(scene, settings, caster) -> Refinement:
    pairs = NearPairs(scene, caster)
    bounds = {"max_edge": settings.max_edge, "max_area": settings.max_area}
    if settings.max_edge is None and settings.max_area is None:
        bounds["max_edge"] = float(np.sqrt(scene.areas.sum() / settings.elements))
    refinement = refine(scene, **bounds, finer=partial(near_knots, scene, pairs))
    warn_of_tiny_patches(scene, caster.least)
    warn_of_flush_lights(scene)
    warn_of_near_lights(scene, refinement, pairs)
    return refinement


def _hemisphere_rays(count, grids, most):
    """The first grid of which ``count`` have at most ``most`` rays, else the last one."""
    return next((grid for grid in grids if grid[0] * grid[1] * count <= most), grids[-1])


class _Shader:
    """Radiance along rays in a scene whose indirect light is known."""

    def __init__(self, scene, frusta, caster, tally, indirect: IndirectLight, settings, with_received,
                 in_flight: InFlight, specular=None):
        self._scene, self._indirect, self._depth = scene, indirect, settings.depth
        self._with_received = with_received
        self._casters = {kind: tally.counting(kind, caster) for kind in ("reflection", "refraction")}
        self._specular, self._in_flight = specular, in_flight
        self._light = DirectLight(
            scene, caster, tally, settings.light_samples, frusta=shadow_caster(frusta), in_flight=in_flight,
            rays=settings.width * settings.height * settings.samples * settings.light_samples)
        self._reflected = self._gather(caster, tally, shadow_caster(frusta), settings)
        self._seen = SeenPoints(scene)
        self._materials = {name: scene.channels(name) for name in ("diffuse", "specular", "transparent", "emission")}
        self._is_diffuse = self._materials["diffuse"].any(axis=1)
        self._is_specular = (self._materials["specular"] + self._materials["transparent"]).any(axis=1)
        self._most_diffuse = 1 - self._materials["specular"] - self._materials["transparent"]
        self._glass = Glass(scene)
        self._index = np.where(self._glass.thin, 1.0, scene.channels("refraction_index"))

    def _gather(self, caster, tally, frusta, settings):
        """By frusta a hemisphere for the points of a pixel, or with an estimate of noise for those of either half."""
        share = 1 if frusta is None else settings.samples if settings.noise is None else settings.samples // 2
        rays = SKY_GATHER if self._scene.has_sky else GATHER
        return FinalGather(self._scene, self._indirect, caster, tally,
                           max(LEAST_GATHER, rays * share // settings.samples), frusta,
                           together=None if frusta is None else share, in_flight=self._in_flight)

    def trace(self, rays: Rays, hits: Hits, key: np.ndarray, rank: np.ndarray,
              field: np.ndarray | None = None) -> np.ndarray:
        """Radiance (rows 0 to 2), tests, steps and received light (rows 3 to 5) of R rays with known hits.

        Breadth first: all rays of a generation, with their shadow rays, before the next one. Only parts of a generation
        that is too large to be in flight go on one after the other.

        ``key`` seeds the samples of lights; those of rays with neighbouring ``rank`` spread together. ``field`` numbers
        rays that pass through the middles of fields.
        """
        count = len(rays)
        result, keys = np.zeros((6, count)), np.full(count, key, dtype=np.uint64)
        waiting = [(0, (rays, hits, np.arange(count), np.ones((count, 3)), keys, rank, field))]
        while waiting:
            depth, generation = waiting.pop()
            branches = [branch for branch in self._add_seen(result, *generation, depth) if len(branch[0])]
            if branches:
                all_rays, all_hits, *rest = zip(*branches, strict=True)
                values = _joined(all_rays), _joined(all_hits), *map(np.concatenate, rest)
                parts = [slice(*part) for part in spans(len(values[0]), self._in_flight.generation)]
                waiting += [(depth + 1, (*(value[part] for value in values), None)) for part in reversed(parts)]
        return result

    def _add_seen(self, result, rays, hits, owner, weight, key, rank, field, depth):
        """Add what rays of one generation see, times ``weight``, to their owners; yields branches of the next one."""
        light = self._scene.background_along(rays.direction)
        met = np.flatnonzero(hits.patch >= 0)
        patch, u, v = hits.patch[met], hits.u[met], hits.v[met]
        points, direction, front = self._seen.at(rays, hits, met)
        active = front | self._scene.two_sided[patch]
        light[met] = np.where(active[:, None], self._materials["emission"][patch], 0)
        measured = self._with_received and depth == 0
        diffuse = np.flatnonzero(active & (self._is_diffuse[patch] | measured))
        direct, gathered = (mix(key[met[diffuse]], use) for use in (4, 7))
        arriving = self._light.irradiance(points[diffuse], direct, rank[met[diffuse]])
        arriving += self._reflected.light(points[diffuse], u[diffuse], v[diffuse], front[diffuse], gathered,
                                          rank[met[diffuse]])
        light[met[diffuse]] += self._diffuse(patch[diffuse], points.position[diffuse]) * arriving
        _add(result, owner, light, weight, hits.tests, hits.steps)
        if measured:
            result[5] += np.bincount(owner[met[diffuse]], luminance(arriving), result.shape[1])
        if depth < self._depth:
            yield from self._next(points, direction, front, active, owner[met], weight[met], key[met], rank[met],
                                  None if field is None or self._specular is None else field[met])

    def _diffuse(self, patch, position):
        """Diffuse reflectances, K x 3, at positions on patches."""
        diffuse = self._materials["diffuse"][patch]
        if self._scene.textures is None:
            return diffuse
        return np.minimum(diffuse * self._scene.textures.ratio(patch, position), self._most_diffuse[patch])

    def _next(self, points, direction, front, active, owner, weight, key, rank, field):
        """Mirrored and refracted rays."""
        kept = np.flatnonzero(self._is_specular[points.patch])
        if not len(kept):
            return
        points, direction, front, active, owner, weight, key, rank = (
            values[kept] for values in (points, direction, front, active, owner, weight, key, rank))
        specular = self._materials["specular"][points.patch] * active[:, None]
        transparent = self._materials["transparent"][points.patch]
        cosine = np.clip(-np.einsum("kj,kj->k", direction, points.normal), 1e-6, 1)
        ratio = np.where(front, 1 / self._index[points.patch], self._index[points.patch])
        straight = 1 - ratio**2 * (1 - cosine**2)
        beyond = np.sqrt(np.maximum(straight, 0))
        mirrored = np.where(straight > 0, fresnel(ratio, cosine, beyond), 1.0)
        thin = self._glass.thin[points.patch]
        mirrored[thin] = self._glass.mirrored(points.patch[thin], cosine[thin])
        reflected = direction + 2 * cosine[:, None] * points.normal
        # A shading normal may reflect a ray into its surface: there the facet's own normal is used.
        facet = self._scene.normals[points.patch] * np.where(front, 1, -1)[:, None]
        into = np.einsum("kj,kj->k", reflected, facet) <= 0
        flat = direction - 2 * np.einsum("kj,kj->k", direction, facet)[:, None] * facet
        reflected = np.where(into[:, None], flat, reflected)
        refracted = ratio[:, None] * direction + (ratio * cosine - beyond)[:, None] * points.normal
        fields = None if field is None else field[kept]
        branches = (("reflection", reflected, specular + transparent * mirrored[:, None],
                     (np.abs(points.normal - facet) < FLAT).all(axis=1)),
                    ("refraction", refracted, transparent * (1 - mirrored)[:, None], thin))
        for branch, (kind, toward, share, is_flat) in enumerate(branches):
            carried = weight * share
            some = np.flatnonzero(carried.max(axis=1) > FAINT)
            rays = Rays(points.position[some], toward[some], self._scene.surface[points.patch[some]])
            hits = self._casters[kind].nearest(rays) if fields is None else self._beyond(
                kind, rays, fields[some], np.flatnonzero(is_flat[some]))
            yield rays, hits, owner[some], carried[some], mix(key[some], 5 + branch), rank[some]

    def _beyond(self, kind, rays, field, flat):
        """The hits of rays behind mirrors or panes, of which those numbered ``flat`` meet flat ones: some as frusta."""
        cast, found = self._specular.nearest(rays[flat], field[flat], is_mirrored=kind == "reflection")
        rows = np.concatenate([flat[cast], np.delete(np.arange(len(rays)), flat[cast])])
        parts = self._casters[kind].count(found), self._casters[kind].nearest(rays[rows[len(cast):]])
        return _joined(parts)[np.argsort(rows)]


def _joined(parts):
    """Rays, or hits, of several one after the other."""
    return type(parts[0])(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in vars(parts[0])})


@compiled
def _add(result, owner, light, weight, tests, steps):
    """Add light times weights, tests and steps of rays to the columns of their owners."""
    for ray in range(len(owner)):
        for channel in range(3):
            result[channel, owner[ray]] += light[ray, channel] * weight[ray, channel]
        result[3, owner[ray]] += tests[ray]
        result[4, owner[ray]] += steps[ray]


def _stats(scene, settings, hemisphere, indirect, tally, found: PixelSums):
    kinds = tally.kinds
    curved = indirect.elements.position.nodes[scene.is_curved[indirect.elements.patch]]
    total = {count: sum(kind[count] for kind in kinds.values()) for count in ("rays", "hits", "tests", "steps")}
    return {
        "scene": scene.name,
        "settings": asdict(settings) | {"rays": [hemisphere.azimuths, hemisphere.polars]}
        | ({"solver": "shooting"} if settings.shooting else {}),
        "patches": len(scene),
        "elements": len(indirect.elements),
        "nodes": indirect.nodes,
        "solver": {"steps": indirect.solution.steps, "converged": indirect.solution.converged},
        "rays": kinds,
        "total": total,
        "tests_per_ray": total["tests"] / total["rays"],
        "steps_per_ray": total["steps"] / total["rays"],
        "seconds": tally.seconds,
        "not_computed": not_computed(scene, has_buried=bool(indirect.buried[curved].any())),
        "noise": None if settings.noise is None or found.error is None else {
            "estimate": float(np.sqrt((found.error**2).mean())), "samples": float(found.rays.mean()),
            "above": int((found.error > settings.noise).sum())},
    }
