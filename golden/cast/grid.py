"""The conventional technique: each ray traverses a uniform grid until its first hit, in float64."""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from golden.base.compiled import is_compiler_active
from golden.base.stage_progress import StageProgress
from golden.cast.nearest import Nearest
from golden.cast.oracle import Oracle, ShearedRays
from golden.cast.ray_caster import RayCaster
from golden.cast.rays import Hits, Rays
from golden.scene.cells import FINEST, Cells, balanced_cell
from golden.scene.scene import Scene

__all__ = ["Grid"]

# Rays per block, such that the arrays of a step stay in a second-level cache.
BLOCK = 1 << 15
# Share of finished rays from which compacting a block pays.
IDLE = 0.25
# A component of a direction this much smaller than the largest one moves no ray by a cell's margin.
STILL = 2.0**-60
# Cost of a test in steps; measured.
TEST_COST = 1.6
# Rays, and cell sizes relative to the balanced one, that choose the default cell size.
TRIAL_RAYS, TRIAL_SIZES = 4096, (1, 0.7, 0.5, 0.35)
# Least rays of a compiled call, and calls per thread.
FEWEST, SHARES = 1 << 12, 8
# Seconds of the stages of the first grid of all, nearly all of them compilation.
EXPECTED = {"cells": 4, "casting": 8}


class Grid(RayCaster):
    """Casts by 3-D digital differential analysis, from cell to cell.

    A ray stops in the first cell in which it has a hit before the cell's exit: no nearer hit can follow. Positions are
    relative to the grid, so the scene's own position costs no precision.

    Compiled, each ray is traversed by itself. Without numba all rays of a block advance by one cell at a time; waiting
    rays replace finished ones, so a few long rays do not hold up a block.

    Parameters
    ----------
    scene
        The patches.
    cell
        Cell size, see `Cells`. Default: of a few sizes the one at which rays from the patches cost least.
    jobs
        Threads, at least 1; the hits do not depend on it. Default: one per processor that this process may use.
    compiled
        Cast by numba; the hits do not depend on it. Default: where it is installed and not switched off.
    progress
        Shows a progress bar after two seconds of preparation: the first grid of all compiles the code.

    Raises
    ------
    InputError
        Cell size or jobs out of range, or float64 does not resolve the scene.
    """

    def __init__(self, scene: Scene, cell: float | None = None, *, jobs: int | None = None,
                 compiled: bool | None = None, progress: bool = False):
        super().__init__(jobs)
        self._compiled = is_compiler_active() if compiled is None else compiled
        self.oracle = Oracle(scene)
        with StageProgress("grid", EXPECTED, shown=progress) as bar:
            with bar.stage("cells"):
                self._fill(Cells(scene, balanced_cell(scene) if cell is None else cell, compiled=self._compiled))
            with bar.stage("casting"):
                if cell is None:
                    self._choose_cells(_trial_rays(scene))
                self.nearest(Rays(np.empty((0, 3)), np.empty((0, 3))))

    def _fill(self, cells):
        """Use these cells."""
        self.cells = cells
        # A border of cells around the grid, marked by a count of -1, ends a ray without a test of its indices.
        x, y, z = cells.shape + 2
        table = np.empty((x, y, z, 2), dtype=np.int32)
        table[[0, -1]] = table[:, [0, -1]] = table[:, :, [0, -1]] = 0, -1
        inner, first = table[1:-1, 1:-1, 1:-1], cells.start[:-1].reshape(cells.shape)
        inner[..., 0] = first
        np.subtract(cells.start[1:].reshape(cells.shape), first, out=inner[..., 1], casting="unsafe")
        self._table = table.reshape(-1, 2)
        self._listed = cells.patch.astype(np.int32)
        self._strides = np.array([y * z, z, 1])

    def _choose_cells(self, rays):
        """Replace the cells by ever smaller ones while that makes the trial rays cheaper."""
        scene = self.oracle.scene
        sizes = np.clip(balanced_cell(scene) * np.array(TRIAL_SIZES), 1 / FINEST, 1)
        best = self.cells, self._cost(rays)
        for cell in np.unique(sizes)[-2::-1].tolist():
            self._fill(Cells(scene, cell, compiled=self._compiled))
            cost = self._cost(rays)
            if cost >= best[1]:
                break
            best = self.cells, cost
        if best[0] is not self.cells:
            self._fill(best[0])

    def _cost(self, rays):
        hits = self.nearest(rays)
        return hits.steps.sum() + TEST_COST * hits.tests.sum()

    def _nearest(self, rays):
        return self._cast(rays, any_hit=False)

    def any_hit(self, rays: Rays) -> Hits:
        """Some hit of each ray before its ``tmax``, on a patch of the first cell that lists a patch with a hit."""
        return self._cast(rays, any_hit=True)

    def _cast(self, rays, *, any_hit):
        return self._cast_compiled(rays, any_hit) if self._compiled else self._cast_in_blocks(rays, any_hit)

    def _cast_compiled(self, rays, any_hit):
        from golden.cast.grid_kernel import cast

        self.oracle.check(rays)
        scene, cells, count = self.oracle.scene, self.cells, len(rays)
        patch, t, u, v = np.empty(count, dtype=np.int32), *np.empty((3, count))
        tests, steps = np.empty((2, count), dtype=np.int64)

        def part(rows):
            cast(rays.origin[rows], rays.direction[rows], rays.source[rows], rays.target[rows], rays.tmax[rows],
                 any_hit, self.oracle.nearest, cells.base, cells.margin, cells.size, cells.shape, self._table,
                 self._listed, scene.vertices, scene.is_triangle, scene.surface,
                 patch[rows], t[rows], u[rows], v[rows], tests[rows], steps[rows])

        self._in_threads(part, count, least=FEWEST, shares=SHARES * self.jobs)
        return Hits(patch=patch, t=t, u=u, v=v, tests=tests, steps=steps)

    def _cast_in_blocks(self, rays, any_hit):
        cells = self.cells
        # Components first, so that gathering one component copies no other.
        lines = _Lines(np.ascontiguousarray(((rays.origin - cells.base) + cells.margin).T),
                       np.ascontiguousarray(rays.direction.T), rays.tmax)
        tests, steps = np.zeros((2, len(rays)), dtype=np.int64)
        job = _Job(lines=lines, sheared=self.oracle.sheared(rays), best=Nearest(rays.tmax), tests=tests, steps=steps,
                   any_hit=any_hit)
        self._in_threads(lambda rows: self._traverse(job, np.arange(rows.start, rows.stop)), len(rays),
                         least=BLOCK, shares=self.jobs)
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
            count = self._table[live.cell, 1]
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
        shape, size = self.cells.shape[:, None], self.cells.size
        origin, direction, extent = lines.origin[:, ray], lines.direction[:, ray], shape * size
        moves = np.abs(direction) > STILL * np.abs(direction).max(axis=0, initial=0)
        inverse = np.divide(1, direction, out=np.zeros_like(direction), where=moves)
        low, high = (0 - origin) * inverse, (extent - origin) * inverse
        inside = (origin >= 0) & (origin <= extent)
        entry = np.where(moves, np.minimum(low, high), np.where(inside, -np.inf, np.inf)).max(axis=0)
        leave = np.where(moves, np.maximum(low, high), np.inf).min(axis=0)
        entry = np.maximum(entry, 0)
        some = np.flatnonzero((entry <= leave) & (entry < lines.tmax[ray]))
        origin, direction, inverse, moves = (a[:, some] for a in (origin, direction, inverse, moves))
        index = np.clip(((origin + direction * entry[some]) / size).astype(int), 0, shape - 1)
        forward = direction > 0
        plane, between = (index + forward) * size, np.where(forward, size, -size)
        stride = np.where(moves, np.where(forward, 1, -1), 0) * self._strides[:, None]
        return _Block(ray=ray[some], cell=self._strides @ (index + 1), entry=entry[some], origin=origin,
                      inverse=inverse, crossing=np.where(moves, (plane - origin) * inverse, np.inf), plane=plane,
                      between=between, stride=stride)

    def _test(self, job, live, full, count, exit_):
        """Test the rays ``full`` of the traversal against the patches of their cells."""
        ray, cell = live.ray[full], live.cell[full]
        pair = np.repeat(np.arange(len(full)), count)
        first = self._table[cell, 0] - (np.cumsum(count) - count)
        patch = self._listed.take(np.arange(len(pair)) + first.take(pair))
        if job.any_hit:
            ray = ray.take(pair)
        else:
            crosses = self._crosses(job, live, full, exit_, pair, patch)
            patch, ray = patch[crosses], ray.take(pair[crosses])
        hit, t = self.oracle.hits(job.sheared, ray, patch, job.lines.tmax[ray])
        job.best.update(ray[hit], patch[hit], t)

    def _crosses(self, job, live, full, exit_, pair, patch):
        """The pairs whose ray crosses the patch's plane within its cell: no other can hit the patch there."""
        ray, entry = live.ray[full], live.entry[full]
        span = np.minimum(exit_, job.best.t[ray]) - entry
        normal, offset, slack = self._planes
        begin, change = -offset.take(patch), 0.0
        for axis in range(3):
            component, direction = normal[axis].take(patch), job.lines.direction[axis].take(ray)
            begin += component * (live.origin[axis].take(full) + entry * direction).take(pair)
            change = change + component * (direction * span).take(pair)
        end, slack = begin + change, slack.take(patch)
        return np.flatnonzero((np.minimum(begin, end) <= slack) & (np.maximum(begin, end) >= -slack))

    @cached_property
    def _planes(self):
        """Planes n . x = offset relative to the grid, and the largest distance of their vertices from them."""
        scene, cells = self.oracle.scene, self.cells
        normal, vertices = np.ascontiguousarray(scene.normals.T), scene.vertices - cells.base + cells.margin
        offset = np.einsum("ij,ij->i", scene.normals, vertices[:, 0])
        distance = np.einsum("ij,ikj->ik", scene.normals, vertices) - offset[:, None]
        return normal, offset, np.abs(distance).max(axis=1) + cells.margin


def _trial_rays(scene):
    """Rays from the patches; half of them start on patches chosen by area."""
    random = np.random.default_rng(0)
    patch = np.concatenate([random.integers(len(scene), size=TRIAL_RAYS // 2),
                            random.choice(len(scene), TRIAL_RAYS // 2, p=scene.areas / scene.areas.sum())])
    # The normal plus a point on the unit sphere is cosine-distributed.
    direction = random.normal(size=(len(patch), 3))
    direction = scene.normals[patch] + 0.999 * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return Rays(scene.centres[patch], direction, scene.surface[patch])


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

    _SINGLE = ("ray", "cell", "entry", "tests", "steps")
    _BY_AXIS = ("origin", "inverse", "crossing", "plane", "between", "stride")

    def __init__(self, *, ray, cell, entry, **by_axis):
        self.ray, self.cell, self.entry = ray, cell, entry
        self.tests, self.steps = np.zeros((2, len(ray)), dtype=np.int64)
        for name in self._BY_AXIS:
            setattr(self, name, list(by_axis[name]))

    def exit(self):
        """T at which each ray leaves its cell."""
        return np.minimum(np.minimum(self.crossing[0], self.crossing[1]), self.crossing[2])

    def advance(self, exit_):
        """Advance each ray by one cell; through an edge or a corner directly into the opposite cell."""
        for axis in range(3):
            moves = self.crossing[axis] <= exit_
            self.cell += np.where(moves, self.stride[axis], 0)
            self.plane[axis] += np.where(moves, self.between[axis], 0.0)
            crossing = (self.plane[axis] - self.origin[axis]) * self.inverse[axis]
            self.crossing[axis] = np.where(moves, crossing, self.crossing[axis])
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
        for name in self._SINGLE:
            setattr(self, name, change(getattr(self, name), *(getattr(other, name) for other in others)))
        for name in self._BY_AXIS:
            components = zip(getattr(self, name), *(getattr(other, name) for other in others), strict=True)
            setattr(self, name, [change(*component) for component in components])
