"""KOAN's machine: a scene in shared pages, whose picture is made by machines of any size."""

import numpy as np

from golden.cast.grid import Grid
from golden.machines.koan.koan_run import KoanRun, simulate_picture
from golden.machines.koan.page_timing import PageTiming
from golden.machines.koan.pixel_rays import PixelRays, pixel_rays
from golden.machines.koan.ray_pages import PageString, ray_pages
from golden.machines.koan.ray_work import RayWork
from golden.machines.koan.scene_pages import ScenePages
from golden.scene.cells import FINEST
from golden.scene.scene import Scene

__all__ = ["KoanMachine", "koan_cell"]


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
    work
        Of rays.
    alone
        Seconds of one node without faults, if they are known.
    progress
        Shows a progress bar after two seconds.

    Raises
    ------
    InputError
        The cell or the size is out of range.
    """

    def __init__(self, scene: Scene, *, size: tuple[int, int], cell: float | None = None, work: RayWork | None = None,
                 alone: float | None = None, progress: bool = False):
        self._grid = Grid(scene, koan_cell(scene) if cell is None else cell, progress=progress)
        self._patches, self._strings = len(scene), {}
        self.traced: PixelRays = pixel_rays(scene, self._grid, size=size)
        self.work = (work or RayWork()).of_groups(self.traced.hits, self.traced.pixel, size[0] * size[1], alone=alone)

    def string(self, page_bytes: int) -> tuple[ScenePages, PageString]:
        """The pages of the scene, and the references of each pixel to them."""
        if page_bytes not in self._strings:
            layout = ScenePages.of(self._grid.cells, self._patches, page_bytes)
            self._strings[page_bytes] = layout, ray_pages(
                self._grid.cells, layout, self.traced.rays, self.traced.hits, self.traced.pixel, len(self.work))
        return self._strings[page_bytes]

    def run(self, *, nodes: int, page_bytes: int = 4096, frames: int = 512, side: int = 3, schedule: str = "mixed",
            timing: PageTiming | None = None, log: int = 0) -> KoanRun:
        """Simulate a machine, see `simulate_picture`."""
        layout, string = self.string(page_bytes)
        return simulate_picture(self.traced.picture, string, self.work, layout, nodes=nodes, frames=frames, side=side,
                                schedule=schedule, timing=timing, log=log)
