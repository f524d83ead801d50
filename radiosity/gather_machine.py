"""Gathering on a hypercube: a scene's rows by the golden model, and its radiosity on machines of any size."""

import numpy as np

from golden.cast.methods import frustum_caster
from golden.light.form_factors import PatchRows
from golden.light.solvers import RadiositySystem
from golden.machines.gather.gather_run import GatherRun, simulate_gather
from golden.machines.gather.node_memory import NodeMemory
from golden.machines.gather.node_timing import NodeTiming
from golden.machines.gather.projection_work import ProjectionWork
from golden.machines.gather.row_phase import GatherScheme
from golden.scene.scene import Scene

__all__ = ["GatherMachine"]


class GatherMachine:
    """Simulates machines that gather the radiosity of one scene; its rows are cast once.

    Reflectances and emissions are those of diffuse surfaces; lights without an area and the background do not count.

    Parameters
    ----------
    scene
        The patches.
    rays
        Azimuths and polar angles of the hemispheres, from the middle of each patch.
    timing
        Of a node.
    progress
        Shows a progress bar after two seconds.

    Raises
    ------
    InputError
        The numbers of rays are out of range.
    """

    def __init__(self, scene: Scene, *, rays: tuple[int, int], timing: NodeTiming | None = None,
                 progress: bool = False):
        self._scene, self._timing = scene, timing or NodeTiming()
        caster = frustum_caster(scene, "grid", progress=progress)
        rows = PatchRows(scene, caster, rays=rays, progress=progress)
        self.system = RadiositySystem(
            form_factors=rows.rows(np.arange(len(scene))), reflectance=np.minimum(scene.channels("diffuse"), 1),
            emission=scene.channels("emission"), area=scene.areas)
        self.work = ProjectionWork(scene, self._timing)

    def run(self, scheme: GatherScheme, *, nodes: int, solver: str = "gauss-jacobi", completion: str | None = None,
            memory: NodeMemory | None = None) -> GatherRun:
        """Simulate both phases, see `simulate_gather`."""
        return simulate_gather(self.system, self.work, scheme, nodes=nodes, solver=solver, completion=completion,
                               timing=self._timing, memory=memory)
