"""Machines that check the rules of their components, and whose registers and memories begin with random values."""

import functools
from contextlib import nullcontext
from pathlib import Path

import pytest

from golden.config import Config
from golden.noc.topology import TOPOLOGIES
from hw.cluster import Cluster
from hw.engine import CLUSTER, Engine
from hw.export import verilog_of
from hw.simulator import machine_library, simulated_port
from tb.lib.random_initial import with_random_initial_values
from tb.lib.seed import SEED

__all__ = ["checked_machine", "use_checked_machines"]


@functools.cache
def checked_machine(config: Config) -> Path:
    """The library of a machine, a violated rule of which ends the process with a message of Verilator."""
    one = config.replace({"noc.topology": TOPOLOGIES[0]})
    texts = {"top_verilog": lambda _: _text(Engine(config=config, black_boxes=True), "top"),
             "cluster_verilog": lambda _: _text(Cluster(config=one), CLUSTER)}
    flags = tuple("--assert" if flag == "--noassert" else flag for flag in machine_library._FLAGS)
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (texts | {"export_beside": lambda _: nullcontext(), "_FLAGS": flags}).items():
            patch.setattr(machine_library, name, value)
        return machine_library.machine_library(config)


def use_checked_machines(patch: pytest.MonkeyPatch) -> None:
    """Let ports without waveforms have checked machines, so that none of the same configuration is built beside."""
    build = machine_library.machine_library
    patch.setattr(simulated_port, "machine_library", lambda config, *, traced=False, progress=None: (
        build(config, traced=traced, progress=progress) if traced else checked_machine(config)))


def _text(component, name):
    return with_random_initial_values(verilog_of(component, name, is_checked=True), SEED)
