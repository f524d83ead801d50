"""The engine with any number of clusters, simulated: a job of hemispheres from a scene's ceiling."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from golden.engine.config import Config
from golden.engine.jobs.descriptor import list_words
from golden.engine.jobs.job import Job, plan_job
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.machines.common.nodes import check_power_of_two, spread_over_nodes
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.job_latencies import job_timing, load_timing
from radiosity.machines.engine.job_runs import JobSpec, PreparedJob, prepare_job
from radiosity.machines.engine.simulated_job import SimulatedJob, phase_casts, simulate_job

__all__ = ["CALIBRATED", "EngineMachine", "EngineRun"]

# Clusters of the largest machine of hardware that simulated cycles have been compared with; of the largest machine
# that is simulated, and of the largest configuration.
CALIBRATED, _CONFIGURED = 16, 64
# Patches of a cluster's memory, unless the user has chosen a number: each cluster holds all of the scene.
_HELD = {"memsys.own_patches": 4096}


@dataclass(frozen=True, kw_only=True, eq=False)
class EngineRun:
    """A job that has been simulated.

    Parameters
    ----------
    prepared, job
        What was cast.
    nodes, groups
        Clusters of the machine, and groups of them that cast a frustum each.
    simulated
        Its cycles.
    dispatch
        Cycles of the dispatcher for all sections.
    """

    prepared: PreparedJob
    job: Job
    nodes: int
    groups: int
    simulated: SimulatedJob
    dispatch: int

    @property
    def cycles(self) -> int:
        """From the begin of the load to the last result."""
        return self.simulated.times.cycles

    @property
    def rays(self) -> int:
        """Rays of all frusta."""
        return sum(map(len, self.prepared.records))

    @property
    def efficiency(self) -> float:
        """Tests per cluster and cycle."""
        return self.simulated.tests / (self.nodes * self.cycles)

    @property
    def is_extrapolated(self) -> bool:
        """Whether the machine is larger than the hardware that it has been compared with."""
        return self.nodes > CALIBRATED

    @property
    def bounds(self) -> dict[str, int]:
        """Least cycles: of the load, and behind it of all casts in equal shares, the longest section, the dispatcher
        and the port of writes.
        """
        times = self.simulated.times
        return {"load": times.load, "casts": -(-self.simulated.cast_cycles // self.nodes),
                "longest section": int((times.done - times.begins).max()), "dispatch": self.dispatch,
                "port": int(self.simulated.beats.sum())}

    @property
    def bound(self) -> str:
        """The name of the largest of `bounds`."""
        return max(self.bounds, key=self.bounds.get)

    def report(self) -> dict:
        """Counts ready for JSON."""
        times, casts, config = self.simulated.times, self.simulated.casts, self.job.config
        tests = np.bincount(times.cluster, [cast.tests for cast in casts], minlength=self.nodes)
        busy = np.bincount(times.cluster, times.ends - times.begins, minlength=self.nodes)
        sections, image = np.bincount(times.cluster, minlength=self.nodes), self.job.phases[0].image
        behind = self.cycles - times.load
        return {
            "scene": self.prepared.scene.name, "patches": len(self.prepared.request.geometry),
            "cell": self.prepared.cell, "frusta": len(self.prepared.records), "rays": self.rays, "nodes": self.nodes,
            "groups": self.groups, "sections": len(casts), "is_extrapolated": self.is_extrapolated,
            "cycles": self.cycles, "load_cycles": times.load, "cast_cycles": self.simulated.cast_cycles / self.nodes,
            "tests": self.simulated.tests, "efficiency": self.efficiency, "rays_per_cycle": self.rays / self.cycles,
            "bound": self.bound, "bounds": self.bounds,
            "traffic": {"written_beats": int(self.simulated.beats.sum()),
                        "port_share": float(self.simulated.beats.sum() / behind),
                        "dispatch_share": self.dispatch / behind, "sums": int(self.simulated.words.sum())},
            "memory": {"image_bytes": image.size, "job_bytes": self.job.end - self.job.base,
                       "patches_of_a_cluster": len(image.residents(0)), "capacity": config.memsys.own_patches},
            "of_a_node": spread_over_nodes(
                sections=sections, tests=tests, cast_cycles=busy)}


class EngineMachine:
    """Simulates jobs of one scene on machines of any size; casts of the same sections are made once.

    Parameters
    ----------
    spec
        The job; its ``group`` has no effect.
    config
        A configuration, of any number of clusters. Their memory is for 4096 patches at least, unless it is ``given``.
    given
        Parameters of it, by path, that the user has chosen.
    latency
        Cycles of main memory.
    folder
        Casts are kept there. Default: in memory alone.
    """

    def __init__(self, spec: JobSpec, config: Config, *, given: tuple[str, ...] = (), latency: int = 10,
                 folder: Path | None = None):
        if "memsys.own_patches" not in given and config.memsys.own_patches < _HELD["memsys.own_patches"]:
            config = config.replace(_HELD)
        self._spec, self._config, self._given, self._latency = spec, config, given, latency
        self._folder, self._cell, self._stores = folder, spec.cell, {}

    def run(self, nodes: int, groups: int, *, note: Callable[[int], object] = lambda done: None) -> EngineRun:
        """Simulate the job on so many clusters.

        Parameters
        ----------
        nodes, groups
            Clusters, and groups that cast a frustum each; powers of two.
        note
            See `simulate_job`.

        Raises
        ------
        InputError
            A number is none, or the machine cannot cast the job.
        """
        check_power_of_two("machine", "Nodes", nodes)
        check_power_of_two("machine", "Groups", groups, nodes)
        # Every cluster holds all patches, so nothing is requested of patch nodes.
        config = simulation_config(self._config.replace({"noc.patch_nodes": 0}), clusters=min(nodes, _CONFIGURED),
                                   topology=None, given=self._given, rays=self._spec.rays[0] * self._spec.rays[1])
        prepared = prepare_job(replace(self._spec, cell=self._cell, group=nodes // groups), config)
        self._cell, job = prepared.cell, plan_job([prepared.request], config)
        timing, pipelines = job_timing(config, latency=self._latency), config.ctu.traversal_pipelines(nodes)
        if pipelines not in self._stores:
            self._stores[pipelines] = phase_casts(prepared.request, config, cluster_timing(config), folder=self._folder)
        simulated = simulate_job(
            job, self._stores[pipelines], job_timing=timing,
            load_timing=load_timing(config, latency=self._latency), clusters=nodes, note=note)
        return EngineRun(prepared=prepared, job=job, nodes=nodes, groups=groups, simulated=simulated,
                         dispatch=timing.dispatch * len(simulated.casts) + int(list_words(job.descriptors).sum()))

