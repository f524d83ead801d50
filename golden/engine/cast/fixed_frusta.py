"""Frusta cast in the machine's integers, with hits in float64."""

from abc import ABC, abstractmethod
from collections import defaultdict
from dataclasses import replace
from functools import partial

import numpy as np

from golden.cast.density import Density, Level
from golden.cast.hemisphere import Hemisphere
from golden.cast.known_patches import hits_of_patches
from golden.cast.oracle import Oracle
from golden.cast.ray_frusta import FrustumHits
from golden.cast.rays import Hits, Rays
from golden.cast.screen import Screen
from golden.cast.shadow_rays import ShadowHits, ShadowRays
from golden.engine.cast.dense_windows import DenseWindows
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shadow_frusta import LEAST, shadow_frusta
from golden.engine.cast.shelling import Shelling
from golden.engine.cast.specular_frusta import SpecularCaster
from golden.engine.config import Config, Icu
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.frustum.shadow_record import ShadowRecord
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene

__all__ = ["CELL", "MOST_ACROSS", "MOST_RAYS", "FixedFrusta", "NaiveFixedFrusta", "ShellingFrusta",
           "blocked_by_shelling", "shares"]

# Most rays of a frustum: the largest ray memory.
MOST_RAYS = 1 << 22
# Most fields of a screen across and down.
MOST_ACROSS = 1 << 16
CONFIG = Config(icu=Icu(rays=MOST_RAYS, side_bits=16, patch_bits=24))
# Default cell size of shelling. This model works on all rays of a shell at once: few large shells cost it less than
# many small ones.
CELL = 0.125
# Frusta of a request that a caster may plan with.
SAMPLES = 4


class FixedFrusta(ABC):
    """Casts hemispheres, screens and shadow rays in fixed point.

    It has the members of `golden.cast.ray_frusta.RayFrusta`, and `shadows`.

    Fixed point decides which patch a ray hits. The position of the hit follows in float64 from the ray that the
    integers represent.

    Parameters
    ----------
    scene
        The patches.
    """

    regular = True
    # Frusta of a request are cast together while they have at most so many rays, and one at least.
    together = 0

    def __init__(self, scene: Scene):
        self._scene, self._oracle = scene, Oracle(scene)
        self._samples: tuple[GCoordinates | None, list[FrustumRecord]] = None, []
        self._geometry = PatchGeometry.of(scene, CONFIG.numbers)
        self._cast = self._machine(self._geometry)
        self._picture: tuple[Screen, _Batches] | None = None

    def _machine(self, geometry: PatchGeometry):
        """Function from records of the same rays to, for each of them, patch, tests and steps of each ray."""
        some = self._some(geometry)
        return lambda records: (some(record, np.arange(len(record))) for record in records)

    @abstractmethod
    def _some(self, geometry: PatchGeometry):
        """Function from a frustum and numbers of its rays to patch, tests and steps of each of those."""

    def hemispheres(self, hemisphere: Hemisphere, points, frames, surfaces) -> FrustumHits:
        """Caster of the hemispheres at M points; a request for one ray casts its whole hemisphere.

        Raises
        ------
        InputError
            The hemisphere has more than `MOST_RAYS` rays.
        """
        coordinates, cast = self._for(points)

        def record(number):
            return hemisphere_record(hemisphere, coordinates, points[number], frames[number, 2],
                                     source=int(surfaces[number]), axes=frames[number])
        self._sample(record, len(points), coordinates)
        return partial(_hits, self._oracle, self._cast_together(cast, record, count=len(points), rays=len(hemisphere)))

    def dense_hemispheres(self, density: Density, hemisphere: Hemisphere, points, frames, surfaces):
        """Caster of hemispheres with finer rays where few meet a patch; the parameters are those of `hemispheres`.

        Returns
        -------
        Function from the number of a point to weights (K int64, in units of 2^-(W + `Density.depth`)), K rays, their
        hits, and the number of rays cast, those whose cells were divided included.
        """
        coordinates, cast = self._for(points)
        geometry = self._geometry if coordinates is self._geometry.coordinates else PatchGeometry.of(
            self._scene, CONFIG.numbers, points)
        depth = density.depth(hemisphere)

        def record(number, level):
            grid = Level(hemisphere, level).grid
            return hemisphere_record(grid, coordinates, points[number], frames[number, 2],
                                     source=int(surfaces[number]), axes=frames[number])

        self._sample(partial(record, level=0), len(points), coordinates)
        finer = self._finer(geometry)

        def leaves_of(numbers):
            return _leaves([DenseWindows(density, hemisphere, partial(record, number), geometry, CONFIG)
                            for number in numbers], cast, finer)

        held = _Batches(leaves_of, count=len(points), together=max(1, self.together // len(hemisphere)))

        def dense(number):
            leaves = held[number]
            weight = np.concatenate([level.row_weights[row] << depth - level.level for level, _, row, _ in leaves])
            direction = np.concatenate([level.directions(column, row) for level, column, row, _ in leaves])
            rays = Rays(np.broadcast_to(points[number], direction.shape), direction @ frames[number],
                        source=np.full(len(direction), surfaces[number], dtype=np.int32))
            none = np.zeros(len(direction), dtype=np.int64)
            hits = hits_of_patches(self._oracle, rays, np.concatenate([leaf[3] for leaf in leaves]), tests=none,
                                   steps=none)
            # A cell that is divided has four in its place.
            return weight, rays, hits, len(weight) + (len(weight) - len(hemisphere)) // 3
        return dense

    def screen(self, screen: Screen, side: int) -> FrustumHits:
        """Caster of the rays of a picture through the middles of the pixels' fields.

        Raises
        ------
        InputError
            There are more than `MOST_ACROSS` fields across or down, or more than `MOST_RAYS` in all.
        """
        return partial(_hits, self._oracle, self._fields(
            replace(screen, width=side * screen.width, height=side * screen.height)))

    def _fields(self, screen):
        """A screen that is cast on first use, and kept until another one is requested."""
        if self._picture is None or self._picture[0] != screen:
            coordinates, cast = self._for(np.array([screen.camera.eye]))

            def record(_):
                return screen_record(screen, coordinates)
            self._sample(record, 1, coordinates)
            self._picture = screen, self._cast_together(cast, record, count=1, rays=len(screen))
        return self._picture[1]

    def _cast_together(self, cast, record, *, count, rays):
        """Patch, tests and steps of each ray of frusta of so many rays each."""
        return _Batches(lambda numbers: map(np.stack, cast([record(number) for number in numbers])), count=count,
                         together=max(1, self.together // rays))

    def patches(self, screen: Screen) -> np.ndarray:
        """The patch that each ray of a screen meets, or -1; of the last screen they are known."""
        return self._fields(screen)[0][0]

    def specular(self, screen: Screen, side: int) -> SpecularCaster:
        """Caster of the rays of a picture, through the middles of the pixels' fields, behind flat mirrors and panes."""
        return SpecularCaster(self._oracle, replace(
            screen, width=side * screen.width, height=side * screen.height), self)

    def beyond(self, patches: np.ndarray, screen: Screen, number: np.ndarray) -> tuple[np.ndarray, ...]:
        """The hits of some rays of a screen among some patches: patch among those, or -1, tests and steps, K int64."""
        geometry = self._geometry_for(np.array([screen.camera.eye]))
        return self._some(geometry[patches])(screen_record(screen, geometry.coordinates), number)

    def shadows(self, rays: ShadowRays, *, least: int = LEAST) -> ShadowHits:
        """What is between points of lights and shaded points; see `shadow_frusta` for ``least``.

        Raises
        ------
        InputError
            A point of a light is not finite.
        """
        geometry = self._geometry_for(rays.points)
        hits = ShadowHits(cast=np.zeros(len(rays), dtype=bool), blocked=np.zeros(len(rays), dtype=bool),
                          tests=np.zeros(len(rays), dtype=np.int64), steps=np.zeros(len(rays), dtype=np.int64))
        cast = self._shadow_machine(geometry)
        for group in _grouped(shadow_frusta(rays, geometry.coordinates, least=least), self.together):
            found = cast([record for _, record, _ in group])
            for (rows, _, number), (blocked, tests, steps) in zip(group, found, strict=True):
                hits.cast[rows], hits.blocked[rows] = True, blocked[number]
                hits.tests[rows], hits.steps[rows] = tests[number], shares(steps, len(rows))
        return hits

    def _finer(self, geometry: PatchGeometry):
        """Function from `DenseWindows`, and for each of them a level (the same for all), columns and rows of rays, to
        the patches that they meet.
        """
        return lambda windows, rays: [one.nearest(*given) for one, given in zip(windows, rays, strict=True)]

    @abstractmethod
    def _shadow_machine(self, geometry: PatchGeometry):
        """Function from shadow frusta of the same grid to, for each of them, its blocked rays, the tests of each ray,
        and its cell steps.
        """

    def _sample(self, record, count, coordinates):
        """Keep some of the frusta that will be requested, evenly spread, and their coordinates."""
        numbers = np.linspace(0, count - 1, min(SAMPLES, count), dtype=int)
        self._samples = coordinates, [record(number) for number in numbers]

    def _for(self, points):
        """Coordinates that hold the points, and the caster in them."""
        geometry = self._geometry_for(points)
        return geometry.coordinates, self._cast if geometry is self._geometry else self._machine(geometry)

    def _geometry_for(self, points):
        """The patches in coordinates that hold the points."""
        lower, upper = self._geometry.coordinates.points([[0] * 3, [CONFIG.numbers.scene.high] * 3])
        if ((points >= lower) & (points <= upper)).all():
            return self._geometry
        return PatchGeometry.of(self._scene, CONFIG.numbers, points)


class ShellingFrusta(FixedFrusta):
    """Shelling in fixed point. Tests are counted per ray; the frustum's cell steps are divided evenly among its rays.

    Parameters
    ----------
    scene
        The patches.
    cell
        Cell size, see `Shelling`.

    Raises
    ------
    InputError
        Cell size out of range.
    """

    def __init__(self, scene: Scene, cell: float | None = None):
        self._cell = CELL if cell is None else cell
        super().__init__(scene)

    def _shadow_machine(self, geometry):
        return blocked_by_shelling(geometry, self._cell)

    def _some(self, geometry):
        shelling = Shelling(geometry, CONFIG, cell=self._cell)

        def some(record, number):
            tests = np.zeros(len(record), dtype=np.int64)
            hits, (counts,) = shelling.cast(record, (Sector.around(number, record),), ray_tests=tests)
            return hits.patch[number], tests[number], shares(counts.cell_steps, len(number))
        return some


class NaiveFixedFrusta(FixedFrusta):
    """Brute force in fixed point: all patches against all rays. The hits are those of `ShellingFrusta`."""

    def _shadow_machine(self, geometry):
        naive = NaiveFixed(geometry, CONFIG)
        return lambda records: [(naive.blocked(record), np.full(len(record), len(geometry)), 0) for record in records]

    def _some(self, geometry):
        naive = NaiveFixed(geometry, CONFIG)
        return lambda record, number: (naive.cast(record, number).patch[number], np.full(len(number), len(geometry)),
                                       np.zeros(len(number), dtype=np.int64))


def shares(total: int, count: int) -> np.ndarray:
    """A whole number divided evenly among so many: int64, the first ones have the remainder."""
    share, rest = divmod(total, count)
    return share + (np.arange(count) < rest)


def blocked_by_shelling(geometry: PatchGeometry, cell: float):
    """As `FixedFrusta._shadow_machine`, in cells of a share of the scene's longest side."""
    shelling = Shelling(geometry, CONFIG, cell=cell)

    def cast(record: ShadowRecord):
        tests = np.zeros(len(record), dtype=np.int64)
        blocked, counts = shelling.blocked(record, ray_tests=tests)
        return blocked, tests, counts.cell_steps
    return lambda records: map(cast, records)


def _grouped(frusta, most):
    """Frusta of the same grid, as many as have at most so many positions together, and one at least."""
    held = defaultdict(list)
    for one in frusta:
        size = len(one[1])
        held[size].append(one)
        if size * (len(held[size]) + 1) > most:
            yield held.pop(size)
    yield from held.values()


class _Batches:
    """What is computed of frusta on first use, in batches; the last batch is kept.

    Parameters
    ----------
    compute
        Function from numbers of frusta to what belongs to each of them, in their order.
    count, together
        How many frusta there are, and how many are computed at once.
    """

    def __init__(self, compute, *, count, together):
        self._compute, self._count, self._together = compute, count, together
        self._held = {}

    def __getitem__(self, one):
        if one not in self._held:
            numbers = range(one, min(one + self._together, self._count))
            self._held = dict(zip(numbers, self._compute(numbers), strict=True))
        return self._held[one]


def _hits(oracle, results, frustum, number, rays) -> Hits:
    """The hits of rays ``number`` of frusta ``frustum``, from patch, tests and steps of each ray of a frustum."""
    values = np.empty((3, len(rays)), dtype=np.int64)
    for one in np.unique(frustum).tolist():
        rows = np.flatnonzero(frustum == one)
        values[:, rows] = results[one][:, number[rows]]
    patch, tests, steps = values
    return hits_of_patches(oracle, rays, patch, tests=tests, steps=steps)


def _leaves(windows, cast, finer):
    """What `DenseWindows.cast` returns for each hemisphere, of all of which rays are cast level by level."""
    patches = [patch for patch, _, _ in cast([one.record(0) for one in windows])]
    runs, leaves = [one.cast(patch) for one, patch in zip(windows, patches, strict=True)], [None] * len(windows)
    # Of those that still divide cells what they have been sent.
    sent = dict.fromkeys(range(len(runs)))
    while sent:
        rays = {}
        for number, met in sent.items():
            try:
                rays[number] = runs[number].send(met)
            except StopIteration as over:
                leaves[number] = over.value
        found = finer([windows[number] for number in rays], [*rays.values()])
        sent = dict(zip(rays, found, strict=True))
    return leaves
