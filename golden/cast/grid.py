"""The conventional technique: each ray traverses a uniform grid until its first hit, in float64."""

import os
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np

from golden.cast.nearest import Nearest
from golden.cast.ray_frusta import RayFrusta
from golden.cast.rays import Hits, Rays
from golden.errors import InputError
from golden.oracle import Oracle, ShearedRays
from golden.scene.cells import FINEST, Cells, balanced_cell
from golden.scene.scene import Scene

__all__ = ["Grid"]

# Rays per block, such that the arrays of a step stay in a second-level cache.
BLOCK = 1 << 15
# Share of finished rays from which compacting a block pays.
IDLE = 0.25
FAR = 1e300
# Cost of a test in steps; measured.
TEST_COST = 1.6
# Rays, and cell sizes relative to the balanced one, that choose the default cell size.
TRIAL_RAYS, TRIAL_SIZES = 4096, np.array([1, 0.7, 0.5, 0.35])
MOST_JOBS = 256


class Grid(RayFrusta):
    """Casts by 3-D digital differential analysis; all rays of a block advance by one cell at a time.

    Waiting rays replace finished ones, so a few long rays do not hold up a block. A ray stops in the first cell in
    which it has a hit before the cell's exit: no nearer hit can follow.

    Parameters
    ----------
    scene
        The patches.
    cell
        Cell size, see `Cells`. Default: of a few sizes the one at which rays from the patches cost least.
    jobs
        Threads, at least 1; the hits do not depend on it. Default: one per processor.

    Raises
    ------
    InputError
        Cell size or jobs out of range.
    """

    def __init__(self, scene: Scene, cell: float | None = None, *, jobs: int | None = None):
        if jobs is not None and not 1 <= jobs <= MOST_JOBS:
            raise InputError(f"Jobs must be 1 to {MOST_JOBS}, not {jobs!r}")
        self._jobs = jobs or min(os.cpu_count() or 1, MOST_JOBS)
        self.oracle = Oracle(scene)
        self.cells = Cells(scene, _cheapest(scene) if cell is None else cell)
        # A border of cells around the grid, marked by a count of -1, ends a ray without a test of its indices.
        counts = np.pad(np.diff(self.cells.start).reshape(self.cells.shape), 1, constant_values=-1)
        start = np.pad(self.cells.start[:-1].reshape(self.cells.shape), 1)
        self._counts, self._start = counts.astype(np.int32).ravel(), start.ravel()
        self._strides = np.array([counts.shape[1] * counts.shape[2], counts.shape[2], 1])
        # Planes n . x = offset, and the largest distance of their vertices from them.
        self._normal = np.ascontiguousarray(scene.normals.T)
        self._offset = np.einsum("ij,ij->i", scene.normals, scene.centres)
        distance = np.einsum("ij,ikj->ik", scene.normals, scene.vertices) - self._offset[:, None]
        self._slack = np.abs(distance).max(axis=1) + self.cells.margin

    def nearest(self, rays: Rays) -> Hits:
        """The nearest hit of each ray before its ``tmax``; equal t goes to the smaller patch number."""
        return self._cast(rays, any_hit=False)

    def occluded(self, rays: Rays) -> Hits:
        """Some hit of each ray before its ``tmax``: the nearest one in the first cell that has one."""
        return self._cast(rays, any_hit=True)

    def _cast(self, rays, *, any_hit):
        # Components first, so that gathering one component copies no other.
        lines = _Lines(np.ascontiguousarray(rays.origin.T), np.ascontiguousarray(rays.direction.T), rays.tmax)
        tests, steps = np.zeros((2, len(rays)), dtype=np.int64)
        job = _Job(lines=lines, sheared=self.oracle.sheared(rays), best=Nearest(rays.tmax), tests=tests, steps=steps,
                   any_hit=any_hit)
        # Each thread has rays of its own, so none writes what another reads.
        parts = np.array_split(np.arange(len(rays)), min(self._jobs, max(1, len(rays) // BLOCK)))
        with ThreadPoolExecutor(len(parts)) as threads:
            for _ in threads.map(lambda part: self._traverse(job, part), parts):
                pass
        return job.best.hits(self.oracle, job.sheared, tests=tests, steps=steps)

    def _traverse(self, job, part):
        """Traverse the grid with the rays numbered ``part``."""
        lines, best = job.lines, job.best
        waiting = 0
        live = self._enter(lines, part[:0])
        while len(live.ray) or waiting < len(part):
            if len(live.ray) <= BLOCK // 2 and waiting < len(part):
                live.join(self._enter(lines, part[waiting:waiting + BLOCK // 2]))
                waiting += BLOCK // 2
            count = self._counts.take(live.cell)
            exit_ = live.exit()
            live.steps += count >= 0
            full = np.flatnonzero(count > 0)
            if len(full):
                live.tests += np.maximum(count, 0)
                self._test(job, live, full, count[full], exit_[full])
            done = (count < 0) | (best.t.take(live.ray) <= exit_)
            if job.any_hit:
                done |= best.patch.take(live.ray) >= 0
            live.advance(exit_)
            live.stop(np.flatnonzero(done))
            if np.count_nonzero(done) >= IDLE * len(done):
                job.tests[live.ray[done]], job.steps[live.ray[done]] = live.tests[done], live.steps[done]
                live.keep(np.flatnonzero(~done))

    def _enter(self, lines, ray):
        """The rays that meet the grid, each in its first cell."""
        cells = self.cells
        origin, direction = lines.origin[:, ray], lines.direction[:, ray]
        still = direction == 0
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / direction
            low = (cells.lower[:, None] - origin) * inverse
            high = ((cells.lower + cells.shape * cells.size)[:, None] - origin) * inverse
        inside = (origin >= cells.lower[:, None]) & (origin <= (cells.lower + cells.shape * cells.size)[:, None])
        entry = np.where(still, np.where(inside, -FAR, FAR), np.minimum(low, high)).max(axis=0)
        leave = np.where(still, FAR, np.maximum(low, high)).min(axis=0)
        entry = np.maximum(entry, 0)
        some = np.flatnonzero((entry <= leave) & (entry < lines.tmax[ray]))
        origin, direction, inverse, still = (a[:, some] for a in (origin, direction, inverse, still))
        point = origin + direction * entry[some]
        index = np.clip(((point - cells.lower[:, None]) / cells.size).astype(int), 0, cells.shape[:, None] - 1)
        forward = direction > 0
        with np.errstate(invalid="ignore"):
            crossing = np.where(still, FAR, (cells.lower[:, None] + (index + forward) * cells.size - origin) * inverse)
            between = np.where(still, 0.0, np.abs(cells.size * inverse))
        stride = np.where(still, 0, np.where(forward, 1, -1)) * self._strides[:, None]
        return _Block(ray=ray[some], cell=self._strides @ (index + 1), entry=entry[some],
                     crossing=crossing, between=between, stride=stride)

    def _test(self, job, live, full, count, exit_):
        """Test the rays ``full`` of the traversal against the patches of their cells."""
        lines, best = job.lines, job.best
        ray = live.ray[full]
        direction = [component.take(ray) for component in lines.direction]
        entry = live.entry[full]
        point = [origin.take(ray) + entry * d for origin, d in zip(lines.origin, direction, strict=True)]
        span = np.minimum(exit_, best.t[ray]) - entry
        pair = np.repeat(np.arange(len(full)), count)
        first = self._start.take(live.cell[full]) - (np.cumsum(count) - count)
        patch = self.cells.patch.take(np.arange(len(pair)) + first.take(pair))
        # A ray that does not cross the patch's plane within this cell cannot hit the patch here.
        normal = [component.take(patch) for component in self._normal]
        begin = sum(n * p.take(pair) for n, p in zip(normal, point, strict=True)) - self._offset.take(patch)
        end = begin + sum(n * (d * span).take(pair) for n, d in zip(normal, direction, strict=True))
        slack = self._slack.take(patch)
        crosses = np.flatnonzero((np.minimum(begin, end) <= slack) & (np.maximum(begin, end) >= -slack))
        patch = patch[crosses]
        ray = ray.take(pair[crosses])
        hit, t = self.oracle.hits(job.sheared, ray, patch, lines.tmax[ray])
        best.update(ray[hit], patch[hit], t)


def _cheapest(scene):
    """The best of a few cell sizes for rays from the patches; half of the rays start on patches chosen by area."""
    random = np.random.default_rng(0)
    patch = np.concatenate([random.integers(len(scene), size=TRIAL_RAYS // 2),
                            random.choice(len(scene), TRIAL_RAYS // 2, p=scene.areas / scene.areas.sum())])
    # The normal plus a point on the unit sphere is cosine-distributed.
    direction = random.normal(size=(len(patch), 3))
    direction = scene.normals[patch] + 0.999 * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    rays = Rays(scene.centres[patch], direction, scene.surface[patch])
    sizes = np.clip(balanced_cell(scene) * TRIAL_SIZES, 1 / FINEST, 1)
    return min(np.unique(sizes).tolist()[::-1], key=lambda cell: _cost(Grid(scene, cell, jobs=1).nearest(rays)))


def _cost(hits):
    return hits.steps.sum() + TEST_COST * hits.tests.sum()


class _Lines(NamedTuple):
    """Rays by components: origin and direction 3 x R, tmax R."""

    origin: np.ndarray
    direction: np.ndarray
    tmax: np.ndarray


class _Job(NamedTuple):
    """One casting: its rays, and the arrays of its results, to which each thread writes its own rays' entries."""

    lines: _Lines
    sheared: ShearedRays
    best: Nearest
    tests: np.ndarray
    steps: np.ndarray
    any_hit: bool


class _Block:
    """The state of the rays in traversal; three rows per axis array."""

    def __init__(self, *, ray, cell, entry, crossing, between, stride):
        self.ray, self.cell, self.entry = ray, cell, entry
        self.tests, self.steps = np.zeros((2, len(ray)), dtype=np.int64)
        self.crossing, self.between, self.stride = list(crossing), list(between), list(stride)

    def exit(self):
        """T at which each ray leaves its cell."""
        return np.minimum(np.minimum(self.crossing[0], self.crossing[1]), self.crossing[2])

    def advance(self, exit_):
        """Advance each ray by one cell; through an edge or a corner directly into the opposite cell."""
        for crossing, between, stride in zip(self.crossing, self.between, self.stride, strict=True):
            moves = crossing <= exit_
            self.cell += np.where(moves, stride, 0)
            crossing += np.where(moves, between, 0.0)
        self.entry = exit_

    def stop(self, rows):
        """Move rays out of the grid."""
        self.cell[rows] = 0
        for stride in self.stride:
            stride[rows] = 0

    def keep(self, rows):
        """Drop all other rays."""
        self._change(lambda own: own.take(rows))

    def join(self, other):
        """Append the rays of another block."""
        self._change(lambda own, others: np.concatenate([own, others]), other)

    def _change(self, change, *others):
        for name in ("ray", "cell", "entry", "tests", "steps"):
            setattr(self, name, change(getattr(self, name), *(getattr(other, name) for other in others)))
        for name in ("crossing", "between", "stride"):
            components = zip(getattr(self, name), *(getattr(other, name) for other in others), strict=True)
            setattr(self, name, [change(*component) for component in components])
