"""The paper's machine with any number of clusters, simulated: refinement steps in a scene."""

from dataclasses import dataclass
from functools import cached_property
from itertools import islice

import numpy as np

from golden.base.errors import InputError
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.open import open_scene
from radiosity.machines.common.nodes import check_power_of_two, spread_over_nodes
from radiosity.machines.engine.engine_machine import CALIBRATED
from radiosity.machines.paper.paper_latencies import paper_timing
from radiosity.machines.paper.paper_step import PaperStep, simulate_steps
from radiosity.machines.paper.prepared_step import PreparedStep, prepare_steps
from radiosity.machines.paper.supply import Supply

__all__ = ["PaperMachine", "PaperRun", "PaperSpec"]


@dataclass(frozen=True, kw_only=True)
class PaperSpec:
    """What the machine casts.

    Parameters
    ----------
    scene
        Name of the scene.
    steps, samples
        Refinement steps, and Gauss points along a side of the patch that shoots: a hemisphere at each.
    rays, cell
        Azimuths and polar angles of a hemisphere, and the size of the cells.
    ratio
        Rays for each one of the low-density casting.

    Raises
    ------
    InputError
        There are no steps.
    """

    scene: str
    steps: int = 1
    samples: int = 1
    rays: tuple[int, int] = (256, 64)
    cell: float = 0.0625
    ratio: int = 64

    def __post_init__(self):
        if self.steps < 1:
            raise InputError(f"machine: Steps must be at least 1, not {self.steps!r}")


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperRun:
    """Steps that have been simulated.

    Parameters
    ----------
    spec, supply, nodes, units
        What was cast, by how many intersection and traversal units.
    patches, capacity
        Patches of the scene, and of a cluster's memory.
    steps
        The steps.
    """

    spec: PaperSpec
    supply: Supply
    nodes: int
    units: int
    patches: int
    capacity: int
    steps: tuple[PaperStep, ...]

    @property
    def cycles(self) -> int:
        """Cycles of all steps."""
        return sum(step.cycles for step in self.steps)

    @property
    def tests(self) -> int:
        """Intersection tests of all steps."""
        return int(self._of_nodes("tests").sum())

    @property
    def efficiency(self) -> float:
        """Tests per intersection unit and cycle."""
        return self.tests / (self.nodes * self.cycles)

    @property
    def is_extrapolated(self) -> bool:
        """Whether the machine has more clusters than any hardware that has been simulated."""
        return self.nodes > CALIBRATED

    def total(self, name: str) -> int:
        """A count of `PaperStep` or `ClusterMemory`, of all steps and clusters."""
        return sum(getattr(step, name) if hasattr(step, name) else sum(getattr(one, name) for one in step.memories)
                   for step in self.steps)

    def report(self) -> dict:
        """Counts ready for JSON."""
        spec, steps = self.spec, self.steps
        rays = sum(len(frustum.record) for step in steps for frustum in step.prepared.frusta)
        received = np.sum([[memory.received for memory in step.memories] for step in steps], axis=0)
        return {
            "scene": spec.scene, "patches": self.patches, "cell": spec.cell, "steps": spec.steps,
            "sources": [step.prepared.source for step in steps], "frusta": spec.steps * spec.samples**2, "rays": rays,
            "nodes": self.nodes, "traversal_units": self.units, "supply": self.supply.value,
            "is_extrapolated": self.is_extrapolated, "cycles": self.cycles,
            "step_cycles": [step.cycles for step in steps], "tests": self.tests, "efficiency": self.efficiency,
            "rays_per_cycle": rays / self.cycles,
            "traffic": {"root_cycles": self.total("root_cycles"), "root_share": self.total("root_cycles") / self.cycles,
                        "link_words": self.total("link_words"), "pushed": self.total("pushed"),
                        "requested": self.total("replies"), "dropped": self.total("dropped"),
                        "messages": sum(len(merged.patch) for step in steps for merged in step.sums)},
            "memory": {"capacity": self.capacity, "resident_references": self.total("residents"),
                       "cache_hits": self.total("hits"), "main_references": self.total("misses"),
                       "most_held": max(len(memory.held) for step in steps for memory in step.memories),
                       "most_deferred": max(one.most_deferred for step in steps for one in step.counts)},
            "of_a_node": spread_over_nodes(
                tests=self._of_nodes("tests"), steps=self._of_nodes("steps"), references=self._of_nodes("patches"),
                received=received,
                cast_cycles=np.sum([[one.ends[-1] for one in step.counts] for step in steps], axis=0))}

    def _of_nodes(self, name):
        return np.sum([[getattr(one, name) for one in step.counts] for step in self.steps], axis=0)


class PaperMachine:
    """Refinement steps on one machine, whose work is made once for all supplies.

    Parameters
    ----------
    spec
        What is cast.
    config
        The configuration.
    nodes
        Intersection units, each of them a cluster: a power of two.
    units
        Traversal units. Default: two for each cluster.
    latency
        Cycles of main memory.

    Raises
    ------
    InputError
        A number is none, or the machine cannot cast the scene.
    """

    def __init__(self, spec: PaperSpec, config: Config, *, nodes: int, units: int | None = None, latency: int = 10):
        check_power_of_two("machine", "Nodes", nodes)
        self._spec, self._config, self._nodes, self._latency = spec, config, nodes, latency
        self._units = 2 * nodes if units is None else units
        self._scene = open_scene(spec.scene)

    @cached_property
    def steps(self) -> tuple[PreparedStep, ...]:
        """The work of the steps."""
        spec = self._spec
        return tuple(islice(prepare_steps(
            self._scene, self._config, cell=spec.cell, hemisphere=Hemisphere(*spec.rays), order=spec.samples,
            clusters=self._nodes, units=self._units, ratio=spec.ratio), spec.steps))

    def run(self, supply: Supply) -> PaperRun:
        """Simulate the steps with a supply of patches."""
        steps = simulate_steps(self.steps, self._config, paper_timing(self._config, latency=self._latency),
                               supply=supply)
        return PaperRun(spec=self._spec, supply=supply, nodes=self._nodes, units=self._units, patches=len(self._scene),
                        capacity=self._config.memsys.own_patches, steps=tuple(steps))

    def differences(self) -> int:
        """Rays whose hits differ from those of golden's shelling of whole frusta."""
        shelling = Shelling(PatchGeometry.of(self._scene, self._config.numbers), self._config, cell=self._spec.cell)
        return sum(len(shelling.cast(frustum.record)[0].differences(frustum.hits))
                   for step in self.steps for frustum in step.frusta)
