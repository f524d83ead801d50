"""Every port of every block of a cluster and of the engine reads what it is meant to read.

All blocks do nothing. Their outputs are drawn at random; each input must then have the value of its line in the
tables below, and no input may be without a line.
"""

import random

import pytest
from amaranth.hdl import Cat, Const, Mux, Value
from amaranth.lib.wiring import Out

import hw.cluster
import hw.engine
from golden.config import PRESETS
from hw.cluster import RECORDED, UNIT_COUNTERS, Cluster
from hw.engine import FETCH, PRELOAD, Engine
from hw.memsys.image_layout import RegionNumber
from hw.memsys.system_bus_interface import READERS
from hw.registers.counter_choice import CounterChoice
from hw.registers.engine_registers import COUNTER_BITS, MAGIC, VERSION
from tb.system.connections import Connections

CONFIG = PRESETS["tiny"].replace({"ctu.subshell_bits": 10, "noc.columns": 2, "noc.rows": 1})
DRAWS = 40

# The blocks, by the names that the tables give them.
CLUSTER = {
    "memory": "MemorySystem", "intersection": "IntersectionUnit", "traversal": "TraversalUnit", "load": "FrustumLoad",
    "slot": "FrustumSlot", "control": "SectionCast", "results": "SectionResults", "tables": "TableLoad",
    "words": "SkidBuffer", "entries": "SkidBuffer", "near": "NearCellBanks", "cells": "SkidBuffer",
    "merged": "SkidBuffer", "list": "SubshellTable", "remote": "Arbiter", "vertices": "Queue",
    "writer": "ResultWriter", "faults": "ClusterFaults", "choice": "CounterChoice"}
ENGINE = {
    "registers": "Registers", "control": "JobControl", "port": "MainMemoryPort", "completions": "CompletionWriter",
    "fetch": "DescriptorFetch", "dispatch": "JobDispatch", "preload": "PreloadDma", "load": "LoadControl",
    "writes": "WriteMerge", "bus": "LocalBus", "interface": "SystemBusInterface", "first": "Cluster",
    "second": "Cluster", "reads": "Arbiter", "words": "Fork", "held": "SkidBuffer", "network": "PatchNetwork"}

# Streams: the source, and what reads it.
CLUSTER_STREAMS = """
    self.i_word words.i                     load.o_table entries.i              entries.o intersection.i_table
    load.o_grid traversal.i_table           load.o_subshell list.i_load         tables.o_cells memory.i_load_cells
    tables.o_lists memory.i_load_lists      tables.o_types memory.i_load_types
    tables.o_geometry memory.i_load_geometry
    slot.o_near near.i_load                 near.o traversal.i_near             control.o_memory memory.i_start
    cells.o memory.i_cell                   memory.o_vertex merged.i            merged.o intersection.i_vertex
    traversal.o_tile intersection.i_settle  intersection.o_settle traversal.i_word
    traversal.o_entry list.i                list.o traversal.i_entry            vertices.o traversal.i_vertex
    memory.o_request self.o_request         self.i_reply memory.i_reply         self.i_remote remote.i[0]
    memory.o_bus self.o_bus                 self.i_bus memory.i_bus
    control.o_results results.i             results.o_read_out intersection.i_read_out
    results.o_command writer.i              writer.o_done results.i_done        results.o self.o_end
    intersection.o_hit writer.i_hit         intersection.o_sum writer.i_sum
    writer.o_request self.o_write           writer.o_data self.o_write_data     self.i_written writer.i_written
"""
# Of these valid and ready alone; the payloads have lines of their own.
CLUSTER_HANDSHAKES = """
    slot.o control.i                        control.o_near near.i               remote.o memory.i_remote
    traversal.o_patch remote.i[1]           control.o_intersection intersection.i_frustum
    control.o_traversal traversal.i_frustum
"""
# Words are for all clusters or for one.
MINE = "(words.o.payload.is_all | (words.o.payload.cluster == self.number))"
FRUSTUM = ("is_screen", "origin", "matrix", "columns", "rows", "column_bits", "row_bits", "source", "longest_direction")
CLUSTER_LINES = {
    **{f"{where}.{name}": f"slot.o.payload.numbers.{name}" for name in FRUSTUM
       for where in ("intersection.i_frustum.payload", "traversal.i_frustum.payload.traversal.frustum")},
    **{f"{where}.{name}": source for name, source in (
        ("section", "slot.o.payload.section"), ("tiles_across", "control.tiles_across"))
       for where in ("intersection.i_frustum.payload", "traversal.i_frustum.payload.traversal.frustum")},
    "traversal.i_frustum.payload.traversal.to_global": "slot.o.payload.numbers.to_global",
    "traversal.i_frustum.payload.traversal.grid_origin": "slot.o.payload.numbers.grid_origin",
    "traversal.i_frustum.payload.traversal.cells": "load.cells",
    "traversal.i_frustum.payload.last_shell": "slot.o.payload.last_shell",
    "traversal.i_frustum.payload.subshells.first": "0",
    "traversal.i_frustum.payload.subshells['count']": "load.subshells",
    "traversal.i_frustum.payload.subshells.patches": "self.scene.patches",
    # Words of the tables: those of all clusters and of this one.
    "load.i.valid": f"words.o.valid & {MINE}", "load.i.payload": "words.o.payload.item",
    "tables.i.valid": f"words.o.valid & {MINE} & load.i.ready", "tables.i.payload": "words.o.payload.item",
    "words.o.ready": "load.i.ready", "self.loads": " | ".join(f"{name}.valid" for name in (
        "words.o", "entries.o", "load.o_grid", "tables.o_cells", "tables.o_lists", "tables.o_types",
        "tables.o_geometry")),
    "traversal.i_slack.valid": "entries.o.valid & intersection.i_table.ready",
    "traversal.i_slack.payload": "entries.o.payload",
    "memory.scene": "self.scene", "memory.cluster": "self.number", "intersection.patches": "self.scene.patches",
    # Sections.
    "slot.free": "control.free", "self.requests": "slot.requests",
    "control.i.payload": "slot.o.payload.section", "near.i.payload.bank": "slot.o.payload.bank",
    "near.i.payload['count']": "slot.o.payload.near_cells",
    "results.begins": "control.begins", "self.begins": "control.begins", "results.results": "slot.o.payload.results",
    # Cells and patches.
    "cells.i.valid": "traversal.o.valid & ~traversal.o.payload.final", "cells.i.payload": "traversal.o.payload.cell",
    "traversal.o.ready": "cells.i.ready",
    "control.final": "traversal.o.valid & cells.i.ready & traversal.o.payload.final",
    "control.closed": "traversal.closed",
    "control.drained": "memory.drained & ~cells.o.valid", "traversal.settled": "control.idle",
    "control.leaves": "intersection.o_done.valid",
    "intersection.o_done.ready": "1",
    # Patches of subshells, under this cluster's own number.
    "remote.i[1].payload.node": "self.number", "remote.i[1].payload.patch": "traversal.o_patch.payload",
    "memory.i_remote.payload": "remote.o.payload.item",
    "vertices.i.valid": "memory.o_remote.valid & (memory.o_remote.payload.node == self.number)",
    "vertices.i.payload": "memory.o_remote.payload.vertex",
    "self.o_remote.valid": "memory.o_remote.valid & (memory.o_remote.payload.node != self.number)",
    "self.o_remote.payload": "memory.o_remote.payload",
    "memory.o_remote.ready":
        "Mux(memory.o_remote.payload.node == self.number, vertices.i.ready, self.o_remote.ready)",
    # Faults and counters.
    "faults.memory": "memory.fault", "faults.final": "control.final", "faults.error": "traversal.error",
    "faults.clear": "results.clear", "memory.clear": "results.clear", "self.fault": "faults.fault",
    "results.fault": "faults.fault", "results.cycle": "self.cycle", "results.cycles": "control.cycles",
    **{f"results.counts.{name}": counter.replace("_", ".counters.", 1) for name, counter in RECORDED.items()},
    "choice.counter": "self.counter", "self.count": "choice.count", "choice.counts[0]": "control.cycles",
    **{f"choice.counts[{1 + number}]": counter for number, counter in enumerate(
        f"{unit}.counters.{name}" for unit, counters in UNIT_COUNTERS.items() for name in counters)},
}

ENGINE_STREAMS = """
    fetch.o dispatch.i                      dispatch.o_sent control.i_sent      dispatch.o_load control.i_load
    dispatch.o_refused control.i_refused    control.o_record completions.i_record
    completions.o_collected control.i_collected
    load.o_command preload.i                preload.o_done load.i_done          preload.o load.i_word
    load.o_word held.i                      held.o words.i                      control.o_load load.i
    registers.command control.i_command     registers.interrupt control.i_interrupt
    load.o_over control.load_over
    bus.o_request interface.i_request       interface.o_reply[0] bus.i_reply[0] interface.o_reply[1] bus.i_reply[1]
    completions.o_request writes.i_request[2]                                   completions.o_data writes.i_data[2]
    writes.o_written[2] completions.i_written
""" + "".join(f"""
    words.o[{n}] {cluster}.i_word           {cluster}.o_end completions.i[{n}]
    {cluster}.o_write writes.i_request[{n}] {cluster}.o_write_data writes.i_data[{n}]
    writes.o_written[{n}] {cluster}.i_written
    {cluster}.o_bus bus.i_request[{n}]      bus.o_reply[{n}] {cluster}.i_bus
    {cluster}.o_request network.i_request[{n}]                                  network.o_reply[{n}] {cluster}.i_reply
    network.o_request[{n}] {cluster}.i_remote                                   {cluster}.o_remote network.i_reply[{n}]
""" for n, cluster in enumerate(("first", "second")))
ENGINE_HANDSHAKES = "interface.o_request reads.i[0]  preload.o_request reads.i[1]  fetch.o_request reads.i[2]"
READS = {"interface": "port.o_read.payload.tag < READERS", "preload": "port.o_read.payload.tag == PRELOAD",
         "fetch": "port.o_read.payload.tag == FETCH"}
ENGINE_LINES = {
    # Reads: each reader's requests with its tag, and the beats of that tag.
    **{f"reads.i[{n}].payload.{name}": f"{reader}.o_request.payload.{name}"
       for n, reader in enumerate(READS) for name in ("address", "length")},
    "reads.i[0].payload.tag": "interface.o_request.payload.tag", "reads.i[1].payload.tag": "PRELOAD",
    "reads.i[2].payload.tag": "FETCH", "port.i_read.valid": "reads.o.valid & ~control.stops",
    "reads.o.ready": "port.i_read.ready", "port.i_read.payload": "reads.o.payload.item",
    **{f"{reader}.i_reply.valid": f"port.o_read.valid & ({mine}) & ~control.stops" for reader, mine in READS.items()},
    **{f"{reader}.i_reply.payload.{name}": f"port.o_read.payload.{name}"
       for reader in READS for name in ("data", "last", "error")},
    "interface.i_reply.payload.tag": "port.o_read.payload.tag[:len(interface.i_reply.payload.tag)]",
    "port.o_read.ready": " | ".join(["control.stops", *(
        f"(({mine}) & {reader}.i_reply.ready)" for reader, mine in READS.items())]),
    # Writes: without requests, and with beats that write nothing, in a stop.
    "port.i_write.valid": "writes.o_request.valid & ~control.stops", "writes.o_request.ready": "port.i_write.ready",
    "port.i_write.payload.address": "writes.o_request.payload.address",
    "port.i_write.payload.length": "writes.o_request.payload.length",
    "port.i_write.payload.tag": "writes.o_request.payload.tag",
    "port.i_write_data.valid": "writes.o_data.valid | control.stops", "writes.o_data.ready": "port.i_write_data.ready",
    "port.i_write_data.payload.data": "writes.o_data.payload.data",
    "port.i_write_data.payload.strobe": "Mux(control.stops, 0, writes.o_data.payload.strobe)",
    "writes.i_written.valid": "port.o_written.valid & ~control.stops",
    "port.o_written.ready": "writes.i_written.ready | control.stops",
    "writes.i_written.payload.tag": "port.o_written.payload.tag[:len(writes.i_written.payload.tag)]",
    "writes.i_written.payload.error": "port.o_written.payload.error",
    # The queue.
    "fetch.ring": "control.kept.ring", "fetch.ring_bits": "control.kept.ring_bits",
    "fetch.doorbell": "registers.doorbell", "fetch.taken": "control.taken", "fetch.enable": "control.enable",
    "dispatch.enable": "control.enable", "dispatch.loaded": "control.loaded",
    "dispatch.requests": "Cat(first.requests, second.requests)", "control.begins": "Cat(first.begins, second.begins)",
    "control.unread": "dispatch.failed", "control.dispatches": "dispatch.busy",
    "control.source": "completions.source", "completions.tag": "control.tag",
    "completions.completions": "control.kept.completions", "completions.ring_bits": "control.kept.ring_bits",
    "completions.stops": "control.stops", "completions.retry": "control.retry",
    "control.completed": "completions.completed", "control.empty": "completions.empty",
    "control.unwritten": "completions.failed", "control.address": "completions.address",
    **{f"{cluster}.{name}": source for n, cluster in enumerate(("first", "second")) for name, source in (
        ("number", str(n)), ("reset", "control.stops"), ("cycle", "control.cycles"),
        ("i_job.valid", "dispatch.o.valid"), ("i_job.payload", "dispatch.o.payload"), ("scene", "interface.scene"))},
    # Faults.
    "control.clusters": "Cat(first.fault, second.fault)", "control.networks": "Cat(network.fault[0], network.fault[1])",
    "control.memory_busy": "port.busy", "control.memory_fault": "port.fault", "port.clear": "control.clear",
    # Registers.
    **{f"control.{name}": f"registers.{name}"
       for name in ("ring", "completions", "ring_bits", "doorbell", "image", "watchdog")},
    **{f"registers.{name}": f"control.{name}" for name in ("status", "taken", "cycles", "interrupt_value")},
    "registers.magic": "MAGIC", "registers.version": "VERSION", "registers.clusters": "2",
    "registers.completed": "completions.completed", "registers.error": "control.error.code",
    "registers.error_cluster": "control.error.cluster", "registers.error_address": "control.error.number",
    "registers.flits": "network.flits", "registers.flit_stalls": "network.stalls", "self.irq": "control.irq",
    **{f"registers.{name}": f"interface.{name}" for name in ("cell_hits", "cell_misses", "patch_hits", "patch_misses")},
    "interface.i_invalidate.payload": "registers.policy",
}
# They depend on what has happened before; see the tests at the end, and `tb/system/test_connections.py`.
CLUSTER_STATES = ("slot.i.payload", "slot.i.valid", "control.enters")
ENGINE_STATES = ("dispatch.last_shell", "interface.scene", "interface.bases", "interface.i_invalidate.valid",
                 "load.stored", "port.read_window", "port.write_window", "registers.i_window.payload",
                 "registers.i_window.valid", "registers.o_window.ready", "first.counter", "second.counter")
BUSES = (("self.host", "registers.host"), ("port.axi", "self.axi"))


NAMES = {"Cat": Cat, "Mux": Mux, "READERS": READERS, "PRELOAD": PRELOAD, "FETCH": FETCH, "MAGIC": MAGIC,
         "VERSION": VERSION}


def _pairs(text):
    names = text.split()
    return list(zip(names[::2], names[1::2], strict=True))


class Wiring:
    """A component around blocks that do nothing, and what its tables state of its ports.

    Members
    -------
    blocks
        By their names in the tables; the component is ``self``.
    sources, sinks
        The ports that drive wires, and those that wires drive: signals by their names in the tables.
    """

    def __init__(self, module, names, make):
        self._connections = Connections(module, list(dict.fromkeys(names.values())), make)
        made = {kind: iter(units) for kind, units in self._connections.instances.items()}
        self.blocks = {"self": self._connections.dut, **{name: next(made[kind]) for name, kind in names.items()}}
        assert not [kind for kind, left in made.items() if next(left, None)]
        self.sources, self.sinks = {}, {}
        for block, component in self.blocks.items():
            for path, member, value in component.signature.flatten(component):
                signal = Value.cast(value)
                if len(signal) and not isinstance(signal, Const):
                    name = block + "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
                    is_sink = (member.flow == Out) == (block == "self")
                    (self.sinks if is_sink else self.sources)[name] = signal

    def value(self, text):
        """The value of an expression of a table."""
        return Value.cast(eval(text, NAMES | self.blocks))

    def lines(self, streams, handshakes, lines, buses=()):
        """What each sink reads."""
        whole, partly = _pairs(streams), _pairs(handshakes)
        stated = {f"{there}.payload": f"{here}.payload" for here, there in whole}
        for here, there in whole + partly:
            stated |= {f"{there}.valid": f"{here}.valid", f"{here}.ready": f"{there}.ready"}
        # Streams that are always ready, or without data, have no such port.
        stated = {sink: source for sink, source in stated.items() if sink in self.sinks}
        for here, there in buses:
            for ours, theirs in (here, there), (there, here):
                stated |= {name: theirs + name.removeprefix(ours) for name in self.sinks if name.startswith(f"{ours}.")}
        assert not stated.keys() & lines.keys()
        return stated | lines

    def unsaid(self, lines):
        """Sinks of which the lines do not say all bits."""
        bits = {name: sum(len(self.value(line)) for line in lines if line.startswith(name)
                          and line[len(name):len(name) + 1] in ("", ".", "[")) for name in self.sinks}
        return [name for name, signal in self.sinks.items() if bits[name] != len(signal)]

    def simulate(self, bench):
        """Run a testbench from reset on."""
        self._connections.simulate(bench)

    def differences(self, lines, draws=DRAWS):
        """Lines that do not hold for outputs that are drawn at random."""
        wires = {sink: (self.value(sink), self.value(source)) for sink, source in lines.items()}
        rng, found, sources = random.Random(len(lines)), set(), Cat(*self.sources.values())

        async def bench(ctx):
            for _ in range(draws):
                # At once: each `set` evaluates all logic.
                ctx.set(sources, rng.getrandbits(len(sources)))
                for line, (sink, source) in wires.items():
                    if (ctx.get(sink) - ctx.get(source)) % (1 << len(sink)):
                        found.add(line)
                await ctx.tick()

        self.simulate(bench)
        return found


@pytest.fixture(scope="module")
def cluster():
    return Wiring(hw.cluster, CLUSTER, lambda: Cluster(config=CONFIG))


@pytest.fixture(scope="module")
def engine():
    return Wiring(hw.engine, ENGINE, lambda: Engine(config=CONFIG))


def test_ports_of_a_cluster(cluster):
    lines = cluster.lines(CLUSTER_STREAMS, CLUSTER_HANDSHAKES, CLUSTER_LINES)
    assert sorted(cluster.unsaid(lines)) == sorted(CLUSTER_STATES)
    assert cluster.differences(lines) == set()


def test_ports_of_the_engine(engine):
    lines = engine.lines(ENGINE_STREAMS, ENGINE_HANDSHAKES, ENGINE_LINES, BUSES)
    assert sorted(engine.unsaid(lines)) == sorted(ENGINE_STATES)
    assert engine.differences(lines) == set()


def test_words_of_a_section_reach_their_cluster_a_cycle_later(cluster):
    dut, slot, rng = cluster.blocks["self"], cluster.blocks["slot"], random.Random(1)
    given, found = Value.cast(dut.i_job.payload), Value.cast(slot.i.payload)

    async def bench(ctx):
        mine = 0
        for _ in range(DRAWS):
            valid, number, word = rng.getrandbits(1), rng.getrandbits(len(dut.number)), rng.getrandbits(len(given))
            for port, value in (dut.i_job.valid, valid), (dut.number, number), (given, word):
                ctx.set(port, value)
            is_mine = valid and ctx.get(dut.i_job.payload.cluster) == number
            await ctx.tick()
            assert ctx.get(slot.i.valid) == is_mine
            assert ctx.get(found) == word
            mine += is_mine
        assert 0 < mine < DRAWS

    cluster.simulate(bench)


def test_a_patch_enters_with_the_first_of_its_four_vertices(cluster):
    memory, merged, control = (cluster.blocks[name] for name in ("memory", "merged", "control"))
    rng = random.Random(1)

    async def bench(ctx):
        moved = 0
        while moved < 3 * 4:
            valid, ready = rng.getrandbits(1), rng.getrandbits(1)
            ctx.set(memory.o_vertex.valid, valid)
            ctx.set(merged.i.ready, ready)
            assert ctx.get(control.enters) == (valid and ready and moved % 4 == 0)
            moved += valid and ready
            await ctx.tick()

    cluster.simulate(bench)


def test_a_counter_is_read_from_its_cluster(engine):
    """Once it has arrived; there is none in a cluster that does not exist."""
    registers, units = engine.blocks["registers"], [engine.blocks[name] for name in ("first", "second")]
    last = (1 << COUNTER_BITS) - 1

    async def bench(ctx):
        for cluster, unit in enumerate(units):
            ctx.set(unit.count, 70 + cluster)
        for cluster, counter, waits in (0, 0, 0), (1, 5, 3), (0, last, 1), (2, last, 0), (63, 1, 0), (1, 9, 0):
            ctx.set(registers.o_window.payload, cluster << COUNTER_BITS | counter)
            ctx.set(registers.o_window.valid, 1)
            assert ctx.get(registers.o_window.ready)
            await ctx.tick()
            # The next number waits for the answer.
            ctx.set(registers.o_window.payload, 0)
            ctx.set(registers.i_window.ready, 0)
            for _ in range(CounterChoice.latency):
                assert [ctx.get(unit.counter) for unit in units] == [counter] * len(units)
                assert not ctx.get(registers.o_window.ready)
                assert not ctx.get(registers.i_window.valid)
                await ctx.tick()
            for left in reversed(range(waits + 1)):
                ctx.set(registers.i_window.ready, not left)
                assert (ctx.get(registers.i_window.valid), ctx.get(registers.o_window.ready)) == (1, 0)
                assert ctx.get(registers.i_window.payload) == (70 + cluster if cluster < len(units) else 0)
                await ctx.tick()
            ctx.set(registers.o_window.valid, 0)
            for _ in range(2):
                assert not ctx.get(registers.i_window.valid)
                await ctx.tick()

    engine.simulate(bench)


def test_words_are_stored_when_no_block_has_one(engine):
    """Held, on its way to the clusters, or in one of them; that is known one cycle later."""
    load, held, *clusters = (engine.blocks[name] for name in ("load", "held", "first", "second"))
    sources = [held.o.valid, *(cluster.loads for cluster in clusters)]
    rng = random.Random(2)

    async def bench(ctx):
        before = [0] * len(sources)
        for _ in range(40):
            now = [rng.random() < 0.25 for _ in sources]
            for signal, value in zip(sources, now, strict=True):
                ctx.set(signal, value)
            assert ctx.get(load.stored) == (not (now[0] or any(before)))
            before = now
            await ctx.tick()

    engine.simulate(bench)


@pytest.mark.parametrize("stopped", [False, True])
def test_a_load_of_cells_and_no_other_changes_the_scene_and_empties_the_caches(engine, stopped):
    """The tables are those of the header while the load is busy; a stop ends the wait for the caches."""
    control, load, preload, interface, *clusters = (
        engine.blocks[name] for name in ("control", "load", "preload", "interface", "first", "second"))
    tables = {"cells": preload.cells, "lists": preload.patch_lists, "patches": preload.patches}
    every = (1 << len(control.o_load.payload.regions)) - 1

    async def bench(ctx):
        kept = [(0, 0)] * len(tables)
        for step, takes in enumerate((True, False, True, False), start=1):
            ctx.set(control.o_load.payload.regions, every & ~(0 if takes else 1 << RegionNumber.CELLS.value))
            for valid, ready in (1, 0), (1, 1):
                ctx.set(control.o_load.valid, valid)
                ctx.set(load.i.ready, ready)
                await ctx.tick()
            ctx.set(control.o_load.valid, 0)
            for busy in 1, 0:
                given = [(100 * step + 10 * busy + n, 1000 * step + 100 * busy + n) for n in range(len(tables))]
                for table, (count, address) in zip(tables.values(), given, strict=True):
                    ctx.set(table, {"count": count, "address": address})
                ctx.set(load.busy, busy)
                await ctx.tick()
                kept = given if takes and busy else kept
                assert [(ctx.get(interface.scene[name]), ctx.get(interface.bases[name])) for name in tables] == kept
                for cluster in clusters:
                    assert ctx.get(Value.cast(cluster.scene)) == ctx.get(Value.cast(interface.scene))
            assert not ctx.get(interface.i_invalidate.valid)
            ctx.set(load.o_over.valid, 1)
            await ctx.tick()
            ctx.set(load.o_over.valid, 0)
            for _ in range(3):
                assert ctx.get(interface.i_invalidate.valid) == takes
                await ctx.tick()
            end = control.stops if stopped else interface.i_invalidate.ready
            ctx.set(end, 1)
            await ctx.tick()
            ctx.set(end, 0)
            assert not ctx.get(interface.i_invalidate.valid)

    engine.simulate(bench)
