"""KOAN's machine: a scene in shared pages, whose picture is made by machines of any size."""

from functools import partial

import numpy as np

from golden.cast.frame import frame
from golden.cast.grid import Grid
from golden.cast.rays import Rays
from golden.light.form_factors import PatchRows
from golden.light.solvers import RadiositySystem
from golden.scene.cells import FINEST
from golden.scene.scene import Scene
from radiosity.machines.koan.koan_run import KoanRun, check_machine, simulate_picture
from radiosity.machines.koan.page_timing import PageTiming
from radiosity.machines.koan.pixel_rays import PixelRays, pixel_rays
from radiosity.machines.koan.ray_pages import PageString, ray_pages
from radiosity.machines.koan.ray_work import ray_work
from radiosity.machines.koan.scene_pages import ScenePages
from radiosity.machines.koan.shared_radiosity import WORD_BYTES, SharedRadiosity, simulate_radiosity

__all__ = ["KoanMachine", "KoanRadiosity", "koan_cell"]


def koan_cell(scene: Scene) -> float:
    """A cell size by which a scene has about as many cells as patches; the source does not say how many it has."""
    extent = np.maximum((scene.bounds[1] - scene.bounds[0]) / scene.size, 1e-3)
    return float(np.clip((extent.prod() / len(scene)) ** (1 / 3), 1 / FINEST, 1 / 2))


class KoanMachine:
    """Simulates machines that make one picture of a scene; its rays are cast once.

    Parameters
    ----------
    scene
        The patches.
    size
        Width and height of the picture.
    cell
        Cell size as a share of the scene's longest side; by default that of `koan_cell`.
    progress
        Shows a progress bar after two seconds.

    Raises
    ------
    InputError
        The cell or the size is out of range.
    """

    def __init__(self, scene: Scene, *, size: tuple[int, int], cell: float | None = None, progress: bool = False):
        self._grid = Grid(scene, koan_cell(scene) if cell is None else cell, progress=progress)
        self.patches, self._strings = len(scene), {}
        self.traced: PixelRays = pixel_rays(scene, self._grid, size=size)
        self.work = ray_work(self.traced.hits, self.traced.pixel, size[0] * size[1])

    def string(self, page_bytes: int, frames: int | None = None) -> tuple[ScenePages, PageString]:
        """The pages of the scene, and the references of each pixel to them; by default for a cache of all pages."""
        layout = ScenePages.of(self._grid.cells, self.patches, page_bytes)
        key = page_bytes, len(layout) if frames is None else min(frames, len(layout))
        if key not in self._strings:
            self._strings[key] = ray_pages(self._grid.cells, layout, self.traced.rays, self.traced.hits,
                                           self.traced.pixel, len(self.work), frames=key[1])
        return layout, self._strings[key]

    def run(self, *, nodes: int, page_bytes: int = 4096, frames: int = 512, side: int = 3, schedule: str = "mixed",
            timing: PageTiming | None = None, alone: float | None = None, log: int = 0) -> KoanRun:
        """Simulate a machine, see `simulate_picture`; ``alone`` are seconds of one node without faults, if known."""
        layout, string = self.string(page_bytes, frames)
        work = self.work if alone is None else np.rint(self.work * (alone * 1e9 / self.work.sum())).astype(np.int64)
        return simulate_picture(self.traced.picture, string, work, layout, nodes=nodes, frames=frames, side=side,
                                schedule=schedule, timing=timing, log=log)


class KoanRadiosity:
    """Simulates machines that compute the radiosity of one scene in shared pages; its rows are cast once.

    Reflectances and emissions are those of diffuse surfaces; lights without an area and the background do not count.

    Parameters
    ----------
    scene
        The patches.
    rays
        Azimuths and polar angles of the hemispheres, from the middle of each patch; neighbouring directions follow each
        other.
    cell
        See `KoanMachine`.
    page_bytes
        Bytes of a page.
    progress
        Shows a progress bar after two seconds.

    Raises
    ------
    InputError
        The numbers of rays, the cell or the page are out of range.
    """

    def __init__(self, scene: Scene, *, rays: tuple[int, int], cell: float | None = None, page_bytes: int = 4096,
                 progress: bool = False):
        grid, count = Grid(scene, koan_cell(scene) if cell is None else cell, progress=progress), len(scene)
        rows = PatchRows(scene, grid, rays=rays, progress=progress)
        self.system = RadiositySystem(
            form_factors=rows.rows(np.arange(count)), reflectance=np.minimum(scene.channels("diffuse"), 1),
            emission=scene.channels("emission"), area=scene.areas)
        directions = np.einsum("rk,nki->nri", rows.hemisphere.directions, frame(scene.normals)).reshape(-1, 3)
        group = np.repeat(np.arange(count), len(rows.hemisphere))
        made = Rays(scene.centres[group], directions, source=scene.surface[group])
        hits = grid.nearest(made)
        self.layout = ScenePages.of(grid.cells, count, page_bytes)
        self._string = partial(ray_pages, grid.cells, self.layout, made, hits, group, count)
        self.work = ray_work(hits, group, count)

    def run(self, *, nodes: int, frames: int = 512, timing: PageTiming | None = None) -> SharedRadiosity:
        """Simulate a machine, see `simulate_radiosity`."""
        check_machine(nodes, frames)
        # Pages of the form factors that a node writes are in write mode and stay in its cache.
        written = -(-len(self.work) // nodes) * len(self.work) * WORD_BYTES // self.layout.page_bytes + 2
        return simulate_radiosity(self.system, self._string(frames=frames - written), self.work, self.layout,
                                  nodes=nodes, frames=frames, timing=timing)
