"""Machines that check the rules of their components, and whose registers and memories begin with random values."""

import ctypes
import functools
from contextlib import nullcontext
from pathlib import Path

import pytest
from amaranth.hdl import Elaboratable, Fragment, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from golden.engine.config import Config
from golden.engine.noc.topology import TOPOLOGIES
from hw.cluster import Cluster
from hw.engine import CLUSTER, Engine
from hw.lib.checks import entries_in_use
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE
from hw.registers.register import WORD_BYTES
from radiosity.flow.simulator import machine_library, simulated_port
from radiosity.flow.simulator.build_folder import build_folder
from radiosity.flow.simulator.simulated_port import SimulatedPort, complete
from radiosity.flow.verilog.export import verilog_of
from tb.lib.random_initial import with_random_initial_values
from tb.lib.seed import SEED

__all__ = ["checked_machine", "count_used_entries", "use_checked_machines"]

# Of a cluster's counters the last one that has an address: no machine has one there.
_ENTRIES = (1 << COUNTER_BITS) - 1
# What the harness of a checked machine has beside the other functions.
_HARNESS = """
extern "C" uint64_t machine_entries(Machine* machine) { return machine->top.entries; }
"""


class _Counted(Elaboratable):
    """A component that counts the entries which its buffers have in use: as port ``entries``, or a cluster as the last
    one of its counters.
    """

    def __init__(self, component):
        self._component, members = component, dict(component.signature.members)
        for name in members:
            setattr(self, name, getattr(component, name))
        if "count" in members:
            self.count = Signal.like(component.count)
        else:
            members["entries"], self.entries = Out(32), Signal(32)
        self.signature = wiring.Signature(members)

    def elaborate(self, platform):
        m, inner = Module(), self._component
        m.submodules.component = Fragment.get(inner, platform)
        if hasattr(self, "entries"):
            m.d.comb += self.entries.eq(entries_in_use())
        else:
            m.d.comb += self.count.eq(Mux(inner.counter == _ENTRIES, entries_in_use(), inner.count))
        return m


@functools.cache
def checked_machine(config: Config) -> Path:
    """The library of a machine, a violated rule of which ends the process with a message of Verilator."""
    one = config.replace({"noc.topology": TOPOLOGIES[0]})
    texts = {"top_verilog": lambda _: _text(Engine(config=config, black_boxes=True), "top"),
             "cluster_verilog": lambda _: _text(Cluster(config=one), CLUSTER)}
    harness = build_folder() / "checked" / machine_library.HARNESS.name
    harness.parent.mkdir(parents=True, exist_ok=True)
    harness.write_text(machine_library.HARNESS.read_text() + _HARNESS)
    flags = tuple("--assert" if flag == "--noassert" else flag for flag in machine_library._FLAGS)
    with pytest.MonkeyPatch.context() as patch:
        for name, value in (texts | {
                "export_beside": lambda _: nullcontext(), "_FLAGS": flags, "HARNESS": harness}).items():
            patch.setattr(machine_library, name, value)
        return machine_library.machine_library(config)


def count_used_entries(port: SimulatedPort, clusters: int) -> int:
    """Entries of buffers, and credits, that a checked machine has in use: none while nothing is in flight."""
    count = port._library.machine_entries
    count.restype, count.argtypes = ctypes.c_uint64, (ctypes.c_void_p,)
    return count(port._machine) + sum(
        complete(port.read(COUNTERS_BASE + WORD_BYTES * (cluster << COUNTER_BITS | _ENTRIES)))
        for cluster in range(clusters))


def use_checked_machines(patch: pytest.MonkeyPatch) -> None:
    """Let ports without waveforms have checked machines, so that none of the same configuration is built beside."""
    build = machine_library.machine_library
    patch.setattr(simulated_port, "machine_library", lambda config, *, traced=False, progress=None: (
        build(config, traced=traced, progress=progress) if traced else checked_machine(config)))


def _text(component, name):
    return with_random_initial_values(verilog_of(_Counted(component), name, is_checked=True), SEED)
