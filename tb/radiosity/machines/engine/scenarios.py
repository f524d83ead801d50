"""Runs of the simulators of machines, whose numbers do not depend on compilation."""

import json
import sys
from dataclasses import replace

import numpy as np

from golden.engine.config import PRESETS
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from golden.scene.builtin import builtin_scene
from golden.scene.halve import halved
from radiosity.machines.common.event_heap import event_heap, pop, push
from radiosity.machines.common.hypercube import hypercube
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.job_latencies import bus_timing, joint_timing, store_timing
from radiosity.machines.engine.job_queue import JobSections, run_queue
from radiosity.machines.engine.job_timing import JobTiming
from radiosity.machines.engine.joint_cast import joint_cast
from radiosity.machines.engine.section_trace import SectionTrace
from radiosity.machines.engine.store_path import store_after
from radiosity.machines.gather.node_matrix import NodeMatrix
from radiosity.machines.gather.node_memory import NodeMemory
from radiosity.machines.gather.projection_work import ProjectionWork
from radiosity.machines.gather.redistribution import redistributed
from radiosity.machines.gather.row_phase import SCHEMES, GatherScheme, make_matrix_rows
from radiosity.machines.gather.solution_programs import iteration_program
from radiosity.machines.koan.koan_machine import KoanMachine
from tb.noc.packets import packets
from tb.radiosity.machines.engine.packet_runs import run_packets
from tb.radiosity.machines.gather.nodes import drawn_matrix, drawn_work
from tb.radiosity.machines.koan.programs import drawn_run
from tb.radiosity.machines.torus.torus_cases import run_small

__all__ = ["SCENARIOS", "drawn_trace", "joint_casts", "joint_runs", "joint_traces"]


def _heap():
    """Times, kinds and subjects of events that schedule others."""
    heap, seen = event_heap(64), []
    for number in range(40):
        push(heap, number % 7, number % 3, number)
    for number in range(200):
        seen.append(pop(heap))
        time, kind, subject = seen[-1]
        push(heap, time + subject * 37 % 11, kind, subject * 5 % 97 + number % 2)
    return seen


def _network():
    """Packets of a loaded torus, with the cycles in which they entered, left and were accepted."""
    routing = route(Topology("torus", 4, 4), 2)
    given = packets(np.random.default_rng(5), routing.topology, "uniform", flits=400, load=0.6, longest=6)
    return run_packets(routing, given, buffer_flits=4, arbitration="age")


def _job():
    """Times of a job on three clusters."""
    rng = np.random.default_rng(3)
    cycles = rng.integers(50, 900, 12)
    sections = JobSections(near=rng.integers(0, 9, 12), free=cycles // 2, cycles=cycles, rays=cycles // 3,
                           hits=cycles // 4, sums=rng.integers(0, 60, 12))
    times = run_queue(sections, JobTiming(first=2, dispatch=28, slot=2, restart=2, read_out=9, sums=16, answer=23,
                                          report=10, beats=16, buffers=2), clusters=3, load=100)
    return np.stack([times.cluster, times.begins, times.ends, times.done])


def drawn_trace(rng, *, stages, cells, patches, least, barrier=None):
    """A trace of a section that meets so many cells in each stage, and finds ``patches`` patches from ``least`` on.

    The stage ``barrier`` waits until all before it are over.
    """
    lists = rng.integers(0, 4, stages * cells)
    is_new = np.zeros(lists.sum(), dtype=bool)
    is_new[rng.permutation(len(is_new))[:patches]] = True
    return SectionTrace(
        cycles=np.full(stages, 3 * cells), searches=rng.integers(0, 9, stages), is_barrier=np.arange(stages) == barrier,
        first_cell=np.arange(0, stages * cells + 1, cells), offset=np.tile(np.arange(1, 3 * cells, 3), stages),
        entries=np.append(0, lists.cumsum()), is_new=is_new, patch=least + rng.permutation(patches),
        tests=rng.integers(1, 30, patches))


def joint_traces(clusters, *, barrier=None):
    """A drawn section for each of some clusters, which share patches, and the cluster that holds each patch."""
    rng = np.random.default_rng(7)
    traces = [drawn_trace(rng, stages=4, cells=8, patches=30, least=10 * number, barrier=barrier)
              for number in range(clusters)]
    return traces, rng.integers(0, clusters, 30 + 10 * clusters)


def joint_casts(run, *, columns, rows, holder=None, slots=8, run_ahead=1, cached=None, barrier=None, frames=0,
                in_order=False, **path):
    """Sections that clusters cast together; ``path`` are numbers of the `JointTiming`.

    Drawn clusters hold the patches, or ``holder`` all of them. The stage ``barrier`` of each waits until all before it
    are over. With ``cached``, a placement, every third patch is held by no cluster, and the cache has eight lines. With
    ``frames`` each cluster has a patch store of so many, from which every second patch of its section has been
    requested, and which patches leave ``in_order``.
    """
    config, clusters = PRESETS["paper"], columns * rows
    (traces, home), others = joint_traces(clusters, barrier=barrier), {}
    if holder is not None:
        home[:] = holder
    if cached:
        memsys = config.replace({"memsys.cache_policy": cached, "memsys.patch_lines": 8}).memsys
        home[::3] = -1
        others = {"bus": replace(bus_timing(config, latency=50), outstanding=4, fetches=2, requests=6),
                  "memsys": memsys, "kept": np.arange(0, 12, 3)}
    if frames:
        others |= {"store": replace(store_timing(config), requests=3),
                   "stores": [store_after(frames, trace.patch[::2])[0] for trace in traces], "in_order": in_order}
    return run(traces, home, cluster_timing(config), replace(joint_timing(config), **path),
               routing=route(Topology("mesh", columns, rows), config.noc.virtual_channels),
               buffer_flits=config.noc.buffer_flits, arbitration=config.noc.arbitration,
               router_cycles=config.noc.router_cycles, slots=slots, run_ahead=run_ahead, **others)


def joint_runs(run, **options):
    """Begins and ends of the sections of `joint_casts`, the sources of their patches, and counts."""
    cast = joint_casts(run, **options)
    return np.concatenate([*(np.concatenate([one.begins, one.ends, owner, [one.free, one.cycles]])
                             for one, owner in zip(cast.times, cast.owner, strict=True)), cast.deferred, [cast.reads]])


def _gather():
    """Rows that nodes share and request, the circulation of blocks, and iterations of Gauss-Jacobi."""
    found = []
    for scheme in SCHEMES:
        for free in (40, 400):
            work, memory = drawn_work(3, 14), NodeMemory()
            memory = NodeMemory(size=memory.size - memory.free(14) + free)
            found.append(make_matrix_rows(GatherScheme(name=scheme), np.full(14, 3), work, hypercube(4, work.timing),
                                          memory).ends)
    matrix = redistributed(NodeMatrix.of_rows(drawn_matrix(1, 12, most=5), np.array([0, 3, 6, 9, 12])))
    program = iteration_program("gauss-jacobi", matrix, NodeTiming())
    return np.stack([*found, run_program(program, hypercube(4, NodeTiming()), np.zeros(4), rounds=2)])


def _projections():
    return ProjectionWork(halved(builtin_scene("cornell"), 24), NodeTiming()).of_rows


def _joint():
    return np.concatenate([joint_runs(joint_cast, columns=2, rows=2, cached=cached, frames=frames)
                           for cached, frames in ((None, 0), ("lfu", 0), ("lru", 8))])


def _torus():
    """Sums of a picture on four nodes, and all their tallies, links and walks, as an array and as a hash table."""
    runs = [run_small(glass=0.2, size=(8, 8), nodes=4, delay=delay, storage=storage, entries=64, log=500)
            for storage, delay in (("array", 0), ("hash", 9000))]
    return [int(number) for run in runs for array in (run.sums, run.state.tallies, run.state.links, run.log)
            for number in array.reshape(-1)]


def _koan():
    """What becomes of pages that nodes read and write, with shared items, and the pages of a small picture."""
    run = drawn_run(2, items=3, references=12, is_shared=True)
    layout, string = KoanMachine(builtin_scene("cornell"), size=(6, 6)).string(256)
    return np.concatenate([np.ravel(each) for each in (
        run.log, run.state.counts, run.times.ends, run.references.value.astype(np.int64), layout.first, string.first,
        string.page)])


SCENARIOS = {"heap": _heap, "network": _network, "job": _job, "joint": _joint, "gather": _gather,
             "projections": _projections, "torus": _torus, "koan": _koan}

if __name__ == "__main__":
    json.dump({name: np.asarray(run()).tolist() for name, run in SCENARIOS.items()}, sys.stdout)
