"""Connections of a cluster and of the engine, around units that do nothing but what a test lets them do."""

import numpy as np
import pytest

import hw.cluster
import hw.engine
import hw.icu.intersection_unit
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS
from golden.engine.ctu.near_cells import near_cells
from golden.engine.jobs.descriptor import frustum_descriptor
from golden.engine.memory_map import phase_image
from golden.engine.schedule.phase import schedule
from hw.cluster import Cluster
from hw.control.control_formats import ControlFormats
from hw.control.job_formats import NEAR_INDEX
from hw.engine import FETCH, PRELOAD, Engine
from hw.icu.intersection_unit import IntersectionUnit
from hw.lib.payload import pack, unpack
from hw.memsys.load.image_layout import RegionNumber
from hw.noc.network_fault import NetworkFault
from radiosity.flow.package.example.frustum_load import frustum_payload
from radiosity.flow.package.example.image_words import words
from tb.golden.engine.schedule.scenes import case
from tb.system.connections import Connections

pytestmark = pytest.mark.sim
CONFIG = PRESETS["tiny"].replace({"ctu.subshell_bits": 10, "noc.columns": 2, "noc.rows": 1})
# Without lists of subshells it may have patch nodes.
MIXED = PRESETS["tiny"].replace({"noc.columns": 4, "noc.rows": 1, "noc.patch_nodes": 2})
UNITS = ("MemorySystem", "IntersectionUnit", "TraversalUnit")
BLOCKS = ("Registers", "JobControl", "MainMemoryPort", "CompletionWriter", "DescriptorFetch", "JobDispatch",
          "PreloadDma", "LoadControl", "WriteMerge", "LocalBus", "SystemBusInterface", "PatchNetwork", "Cluster",
          "PatchNode")
PARTS = ("PatchSetup", "IntersectionPipeline", "IcRayGenerator", "SettleMap", "ReadOut")
# No two of them are the same.
SCENE = {"cells": 700, "lists": 1234, "patches": 300}
LIMIT = 100


@pytest.fixture(scope="module")
def made():
    """A scene, and the image of a phase with one frustum."""
    scene = case("cornell", rays=(64, 16), cell=0.25)
    plan = schedule(scene.record, scene.geometry, scene.shelling.table, CONFIG, clusters=2, ratio=16)
    return scene, plan, phase_image([scene.record], scene.geometry, scene.shelling.table, CONFIG, plan=plan,
                                    weights=Hemisphere(64, 16).polar_weights)


@pytest.fixture(scope="module")
def cluster():
    """Cluster 1 of two."""
    return Connections(hw.cluster, UNITS, lambda: Cluster(config=CONFIG))


@pytest.fixture(scope="module")
def engine():
    """An engine of two clusters and two patch nodes."""
    return Connections(hw.engine, BLOCKS, lambda: Engine(config=MIXED))


@pytest.fixture(scope="module")
def intersection():
    """An intersection unit whose ray memory is its own."""
    return Connections(hw.icu.intersection_unit, PARTS, lambda: IntersectionUnit(config=CONFIG))


@pytest.mark.parametrize(("columns", "rows"), [(4, 1 << 10), (1 << 10, 4), (5, 17), (64, 64), (1, 1)])
def test_memories_begin_with_all_tiles_of_a_section(intersection, columns, rows):
    """Rounded up to a power of two along each axis; a section may be as long as there are numbers for."""
    dut, settle, side = intersection.dut, intersection.units["SettleMap"], 1 << CONFIG.icu.tile_bits
    across, down = (-(-count // side) for count in (columns, rows))

    async def bench(ctx):
        ctx.set(dut.i_frustum.payload.section, {
            "first_column": 0, "end_column": columns, "first_row": 0, "end_row": rows})
        ctx.set(dut.i_frustum.payload.tiles_across, across)
        ctx.set(dut.i_frustum.valid, 1)
        await ctx.tick().until(settle.i_start.valid)
        assert ctx.get(settle.tiles) == (1 << (across - 1).bit_length()) * (1 << (down - 1).bit_length())

    intersection.simulate(bench)


def test_units_begin_with_what_was_loaded(cluster, made):
    """The tables of the cluster, and the numbers of the section in its slot."""
    scene, plan, image = made
    record, table = scene.record, scene.shelling.table
    assert len(image.subshells(0)) != len(image.subshells(1)) > 0
    section = plan.partition.sections[1]
    descriptor = frustum_descriptor(record, table, section=section)
    near = near_cells(record, table, record.slopes).astype("<u4")
    sent = [*enumerate(np.frombuffer(descriptor.tobytes(), "<u8").tolist()),
            *((NEAR_INDEX, word) for word in np.frombuffer(np.pad(near, (0, len(near) % 2)).tobytes(), "<u8").tolist())]
    dut, (memory, intersection, traversal) = cluster.dut, (cluster.units[name] for name in UNITS)
    shape, found, cells = ControlFormats(CONFIG).load_word, {}, []

    async def bench(ctx):
        ctx.set(dut.number, 1)
        ctx.set(dut.scene.as_value(), pack(dut.scene.shape(), SCENE))
        ctx.set(intersection.i_table.ready, 1)
        for number in 1, 0:
            for item in words(image, number):
                ctx.set(dut.i_word.payload.as_value(), pack(shape, {"item": item, "cluster": number, "is_all": 0}))
                ctx.set(dut.i_word.valid, 1)
                await ctx.tick().until(dut.i_word.ready)
        ctx.set(dut.i_word.valid, 0)
        await ctx.tick().until(~dut.loads)
        ctx.set(memory.drained, 1)
        # Those of the other cluster come between.
        for number in 0, 1:
            for place, (index, data) in enumerate(sent):
                ctx.set(dut.i_job.payload, {"cluster": number, "index": index, "data": data if number else ~data,
                                            "last": place == len(sent) - 1, "void": 0})
                ctx.set(dut.i_job.valid, 1)
                await ctx.tick()
        ctx.set(dut.i_job.valid, 0)
        for port in memory.i_start, intersection.i_frustum, traversal.i_frustum, traversal.i_near:
            ctx.set(port.ready, 1)
        for _ in range(LIMIT):
            for name, port in ("intersection", intersection.i_frustum), ("traversal", traversal.i_frustum):
                if ctx.get(port.valid):
                    assert name not in found
                    found[name] = unpack(port.payload.shape(), ctx.get(port.payload.as_value()))
            if ctx.get(traversal.i_near.valid):
                cells.append(unpack(traversal.i_near.payload.shape(), ctx.get(traversal.i_near.payload.as_value())))
            await ctx.tick()

    cluster.simulate(bench)
    frustum = frustum_payload(record, section, CONFIG)
    assert found["intersection"] == frustum
    assert found["traversal"] == {
        "traversal": {"frustum": frustum, "to_global": record.to_global.tolist(),
                      "grid_origin": table.position(record.origin).tolist(), "cells": table.shape.tolist()},
        "last_shell": int(descriptor["last_shell"]),
        "subshells": {"first": 0, "count": len(image.subshells(1)), "patches": SCENE["patches"]}}
    assert [one["cell"] for one in cells if one["is_cell"]] == near.tolist()
    assert [one["last"] for one in cells] == [0] * (len(cells) - 1) + [1]


def test_patches_of_every_node_are_reloaded(cluster):
    """Copies of them are old, also if none of them are the cluster's own."""
    dut, reloads = cluster.dut, cluster.units["MemorySystem"].reloads

    async def bench(ctx):
        ctx.set(cluster.units["IntersectionUnit"].i_table.ready, 1)
        for region in RegionNumber:
            for number, is_all in (0, 0), (1, 0), (0, 1):
                item = {"region": region.value, "record": 0, "word": 0, "data": 0}
                ctx.set(dut.i_word.payload.as_value(), pack(ControlFormats(CONFIG).load_word, {
                    "item": item, "cluster": number, "is_all": is_all}))
                ctx.set(dut.i_word.valid, 1)
                await ctx.tick().until(dut.i_word.ready)
                ctx.set(dut.i_word.valid, 0)
                assert ctx.get(reloads) == (region is RegionNumber.PATCHES), f"{region} of {number}"
                await ctx.tick().until(~dut.loads)
                assert not ctx.get(reloads)

    cluster.simulate(bench)


def test_a_cell_between_traversal_and_memory_system_is_in_flight(cluster):
    """The memory system is drained while it has not accepted the cell."""
    memory, traversal = cluster.units["MemorySystem"], cluster.units["TraversalUnit"]

    async def bench(ctx):
        ctx.set(memory.drained, 1)
        assert ctx.get(traversal.settled)
        ctx.set(traversal.o.payload.cell, 9)
        ctx.set(traversal.o.valid, 1)
        await ctx.tick()
        ctx.set(traversal.o.valid, 0)
        for ready in 0, 1:
            ctx.set(memory.i_cell.ready, ready)
            assert (ctx.get(memory.i_cell.valid), ctx.get(traversal.settled)) == (1, 0)
            await ctx.tick()
        assert ctx.get(traversal.settled)

    cluster.simulate(bench)


def test_windows_are_taken_over_when_the_control_says_so(engine):
    units = engine.units

    async def bench(ctx):
        registers, control, port = (units[name] for name in BLOCKS[:3])
        sides = [(getattr(getattr(port, f"{name}_window"), side), getattr(registers, f"{name}_{side}"))
                 for name in ("read", "write") for side in ("base", "limit")]
        for step in 1, 2, 3:
            for number, (_, register) in enumerate(sides):
                ctx.set(register, step << 40 | number)
            ctx.set(control.takes, step == 2)
            await ctx.tick()
            expected = [0 if step == 1 else 2 << 40 | number for number in range(len(sides))]
            assert [ctx.get(window) for window, _ in sides] == expected

    engine.simulate(bench)


def test_a_stop_ends_what_memory_has_accepted_and_nothing_else(engine):
    """Whatever the blocks in reset show: replies are taken and given to nobody, outstanding beats write no byte."""
    units = engine.units

    async def bench(ctx):
        control, port, writes = (units[name] for name in ("JobControl", "MainMemoryPort", "WriteMerge"))
        readers = {None: units["SystemBusInterface"], PRELOAD: units["PreloadDma"], FETCH: units["DescriptorFetch"]}
        every = (1 << CONFIG.memory.beat_bytes) - 1
        for stream in (writes.o_request, writes.o_data, port.o_read, port.o_written,
                       *(reader.o_request for reader in readers.values())):
            ctx.set(stream.valid, 1)
        ctx.set(writes.o_data.payload.strobe, every)
        for stops in 0, 1:
            ctx.set(control.stops, stops)
            for tag, reader in readers.items():
                ctx.set(port.o_read.payload.tag, tag or 0)
                assert ctx.get(port.o_read.ready) == stops
                for other in readers.values():
                    assert ctx.get(other.i_reply.valid) == (other is reader and not stops)
            assert ctx.get(port.i_write_data.valid) == 1
            assert ctx.get(port.i_write_data.payload.strobe) == (0 if stops else every)
            assert ctx.get(port.o_written.ready) == stops
            assert ctx.get(writes.i_written.valid) == (not stops)
            await ctx.tick()
            # The request that was merged before the stop is not passed on.
            assert ctx.get(port.i_read.valid) == ctx.get(port.i_write.valid) == (not stops)
            for name, unit in units.items():
                if name in ("Cluster", "PatchNode"):
                    assert ctx.get(unit.reset) == stops

    engine.simulate(bench)


def test_sections_may_have_the_shells_that_were_loaded(engine, made):
    *_, image = made
    units, regions = engine.units, 1 << RegionNumber.SHELLS.value

    async def bench(ctx):
        preload, load, control = (units[name] for name in ("PreloadDma", "LoadControl", "JobControl"))
        for signal in load.i.ready, load.busy, control.o_load.valid:
            ctx.set(signal, 1)
        ctx.set(control.o_load.payload.regions, regions)
        ctx.set(preload.shells["count"], len(image["shells"]))
        await ctx.tick().repeat(2)
        assert ctx.get(units["JobDispatch"].last_shell) == image.last_shell
        # A load of other tables leaves them.
        ctx.set(control.o_load.payload.regions, 0)
        await ctx.tick()
        ctx.set(preload.shells["count"], 1)
        await ctx.tick().repeat(2)
        assert ctx.get(units["JobDispatch"].last_shell) == image.last_shell

    engine.simulate(bench)


def test_nodes_have_the_numbers_of_their_places_and_clusters_come_first(engine):
    async def bench(ctx):
        assert [ctx.get(engine.units[name].number) for name in ("Cluster", "PatchNode")] == [1, 3], "the last of each"

    engine.simulate(bench)


def test_words_are_stored_when_none_is_held_and_no_node_loads(engine):
    """Nodes of each kind; the word is one that no node takes."""
    load, nodes = engine.units["LoadControl"], [engine.units[name] for name in ("Cluster", "PatchNode")]

    async def bench(ctx):
        for node in nodes:
            for loads in 1, 0:
                ctx.set(node.loads, loads)
                await ctx.tick()
                assert ctx.get(load.stored) == (not loads)
        ctx.set(load.o_word.valid, 1)
        await ctx.tick()
        ctx.set(load.o_word.valid, 0)
        for _ in range(20):
            assert not ctx.get(load.stored)
            await ctx.tick()

    engine.simulate(bench)


def test_a_fault_of_the_network_is_that_of_its_node(engine):
    units, nodes = engine.units, range(4)

    async def bench(ctx):
        network, control = units["PatchNetwork"], units["JobControl"]
        for number, fault in (0, NetworkFault.ORDER), (1, NetworkFault.CHECK), (3, NetworkFault.ORDER):
            for node in nodes:
                ctx.set(network.fault[node], fault if node == number else NetworkFault.NONE)
            assert [ctx.get(control.networks[node]) for node in nodes] == [
                fault if node == number else NetworkFault.NONE for node in nodes]

    engine.simulate(bench)
