"""Gathering on a hypercube: a scene's rows by the golden model, and its radiosity on machines of any size."""

import numpy as np

from golden.engine.cast.methods import frustum_caster
from golden.light.form_factors import PatchRows
from golden.light.image import label_colours
from golden.light.solvers import RadiositySystem
from golden.scene.scene import Scene
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.gather_run import GatherRun, simulate_gather
from radiosity.machines.gather.node_memory import NodeMemory
from radiosity.machines.gather.projection_work import ProjectionWork
from radiosity.machines.gather.row_phase import GatherScheme
from radiosity.machines.merge.merge_machine import framed

__all__ = ["GatherMachine", "row_frames"]

# Frames before the solution; pixels along the square of a row.
_TIMES, _SQUARE = 5, 8


class GatherMachine:
    """Simulates machines that gather the radiosity of one scene; its rows are cast once.

    Reflectances and emissions are those of diffuse surfaces; lights without an area and the background do not count.

    Parameters
    ----------
    scene
        The patches.
    rays
        Azimuths and polar angles of the hemispheres, from the middle of each patch.
    progress
        Shows a progress bar after two seconds.

    Raises
    ------
    InputError
        The numbers of rays are out of range.
    """

    def __init__(self, scene: Scene, *, rays: tuple[int, int], progress: bool = False):
        caster = frustum_caster(scene, "grid", progress=progress)
        rows = PatchRows(scene, caster, rays=rays, progress=progress)
        self.system = RadiositySystem(
            form_factors=rows.rows(np.arange(len(scene))), reflectance=np.minimum(scene.channels("diffuse"), 1),
            emission=scene.channels("emission"), area=scene.areas)
        self.work = ProjectionWork(scene, NodeTiming())

    def run(self, scheme: GatherScheme, *, nodes: int, solver: str = "gauss-jacobi", completion: str | None = None,
            memory: NodeMemory | None = None) -> GatherRun:
        """Simulate both phases, see `simulate_gather`."""
        return simulate_gather(self.system, self.work, scheme, nodes=nodes, solver=solver, completion=completion,
                               memory=memory)


def row_frames(run: GatherRun) -> np.ndarray:
    """H x W x 3 uint8: who holds which row at five times, at equal distances, of the first phase; then in the solution.

    Each row has a square, in the scene's order from left to right and from top to bottom, in the colour of its node,
    and black before it is stored. The square of a row that nodes share is divided by its entries.
    """
    rows, matrix = run.rows, run.matrix
    order, count = rows.assignment.order, len(rows.stored)
    side = int(np.ceil(np.sqrt(count)))
    holder = np.full((_TIMES + 1, side * side, _SQUARE), -1)
    made = np.empty(count, dtype=np.int64)
    made[order] = np.repeat(np.arange(rows.assignment.nodes), rows.assignment.sizes)
    for step, time in enumerate(np.linspace(0, rows.time, _TIMES + 1)[1:]):
        holder[step, :count] = np.where(rows.stored <= time, made, -1)[:, None]
    first, length = matrix.matrix.indptr[:-1, None], np.diff(matrix.matrix.indptr)[:, None]
    entry = first + (np.arange(_SQUARE) + 0.5) / _SQUARE * length
    owner = np.searchsorted(matrix.rows, np.arange(count), side="right")[:, None]
    holder[_TIMES, order] = np.where(length, np.searchsorted(matrix.entries, entry, side="right"), owner) - 1
    squares = holder.reshape(-1, side, side * _SQUARE).repeat(_SQUARE, axis=1)
    return framed(list(label_colours(squares)))
