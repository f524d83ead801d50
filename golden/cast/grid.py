"""The conventional technique: each ray traverses a uniform grid until its first hit, in float64."""

import numpy as np

from golden.base.stage_progress import StageProgress
from golden.cast.oracle import Oracle
from golden.cast.ray_caster import RayCaster
from golden.cast.rays import Hits, Rays
from golden.scene.cells import FINEST, Cells, balanced_cell
from golden.scene.scene import Scene

__all__ = ["Grid"]

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

    Parameters
    ----------
    scene
        The patches.
    cell
        Cell size, see `Cells`. Default: of a few sizes the one at which rays from the patches cost least.
    jobs
        Threads, at least 1; the hits do not depend on it. Default: one per processor that this process may use.
    progress
        Shows a progress bar after two seconds of preparation: the first grid of all compiles the code.

    Raises
    ------
    InputError
        Cell size or jobs out of range, or float64 does not resolve the scene.
    """

    def __init__(self, scene: Scene, cell: float | None = None, *, jobs: int | None = None, progress: bool = False):
        super().__init__(jobs)
        self.oracle = Oracle(scene)
        with StageProgress("grid", EXPECTED, shown=progress) as bar:
            with bar.stage("cells"):
                self._fill(Cells(scene, balanced_cell(scene) if cell is None else cell))
            with bar.stage("casting"):
                if cell is None:
                    self._choose_cells(_trial_rays(scene))
                self.nearest(Rays(np.empty((0, 3)), np.empty((0, 3))))

    def _fill(self, cells):
        """Use these cells."""
        from golden.cast.grid_kernel import GridScene

        self.cells, scene = cells, self.oracle.scene
        # A border of cells around the grid, marked by a count of -1, ends a ray without a test of its indices.
        x, y, z = cells.shape + 2
        table = np.empty((x, y, z, 2), dtype=np.int32)
        table[[0, -1]] = table[:, [0, -1]] = table[:, :, [0, -1]] = 0, -1
        inner, first = table[1:-1, 1:-1, 1:-1], cells.start[:-1].reshape(cells.shape)
        inner[..., 0] = first
        np.subtract(cells.start[1:].reshape(cells.shape), first, out=inner[..., 1], casting="unsafe")
        self._model = GridScene(
            nearest=self.oracle.nearest, base=cells.base, margin=cells.margin, size=cells.size, shape=cells.shape,
            table=table.reshape(-1, 2), listed=cells.patch.astype(np.int32), vertices=scene.vertices,
            is_triangle=scene.is_triangle, surface=scene.surface)

    def _choose_cells(self, rays):
        """Replace the cells by ever smaller ones while that makes the trial rays cheaper."""
        scene = self.oracle.scene
        sizes = np.clip(balanced_cell(scene) * np.array(TRIAL_SIZES), 1 / FINEST, 1)
        best = self.cells, self._cost(rays)
        for cell in np.unique(sizes)[-2::-1].tolist():
            self._fill(Cells(scene, cell))
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
        from golden.cast.grid_kernel import GridHits, GridRays, cast

        self.oracle.check(rays)
        count = len(rays)
        patch, t, u, v = np.empty(count, dtype=np.int32), *np.empty((3, count))
        tests, steps = np.empty((2, count), dtype=np.int64)

        def part(rows):
            cast(self._model, GridRays(rays.origin[rows], rays.direction[rows], rays.source[rows], rays.target[rows],
                                       rays.tmax[rows]), any_hit,
                 GridHits(patch[rows], t[rows], u[rows], v[rows], tests[rows], steps[rows]))

        self._in_threads(part, count, least=FEWEST, shares=SHARES * self.jobs)
        return Hits(patch=patch, t=t, u=u, v=v, tests=tests, steps=steps)


def _trial_rays(scene):
    """Rays from the patches; half of them start on patches chosen by area."""
    random = np.random.default_rng(0)
    patch = np.concatenate([random.integers(len(scene), size=TRIAL_RAYS // 2),
                            random.choice(len(scene), TRIAL_RAYS // 2, p=scene.areas / scene.areas.sum())])
    # The normal plus a point on the unit sphere is cosine-distributed.
    direction = random.normal(size=(len(patch), 3))
    direction = scene.normals[patch] + 0.999 * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    return Rays(scene.centres[patch], direction, scene.surface[patch])
