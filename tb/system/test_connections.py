"""Connections of a cluster and of the engine, around units that do nothing but what a test lets them do."""

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.sim import Simulator

import hw.cluster
import hw.engine
from golden.config import PRESETS
from golden.frustum import Hemisphere
from golden.memory_map import machine_image
from golden.schedule.phase import schedule
from hw.cluster import Cluster
from hw.control.control_formats import ControlFormats
from hw.engine import Engine
from hw.lib.inspection import inspect
from hw.memsys.system_bus_interface import READERS
from tb.control.image_words import words
from tb.golden.schedule.scenes import case
from tb.icu.frustum_load import frustum_payload
from tb.lib.payload import pack, unpack

CONFIG = PRESETS["tiny"].replace({"ctu.subshell_bits": 10, "noc.columns": 2, "noc.rows": 1})
UNITS = ("MemorySystem", "IntersectionUnit", "TraversalUnit")
BLOCKS = ("Registers", "EngineControl", "MainMemoryPort", "PreloadDma", "WriteDma", "LoadControl", "ResultControl",
          "LocalBus", "SystemBusInterface", "PatchNetwork")
# No two of them are the same.
SCENE = {"cells": 700, "lists": 1234, "patches": 300}
LIMIT = 100


class _Unit(wiring.Component):
    """The ports of a unit."""

    def elaborate(self, platform):
        return Module()


def _without(monkeypatch, module, names):
    """The units of ``module`` do nothing from now on; those that are made, by name."""
    units = {}

    def replace(name, real):
        def make(*given, **named):
            units[name] = _Unit(inspect(lambda: real(*given, **named), lambda unit: unit.signature))
            return units[name]

        monkeypatch.setattr(module, name, make)

    for name in names:
        replace(name, getattr(module, name))
    return units


@pytest.fixture
def cluster(monkeypatch):
    """Cluster 1 of two, and its units by name."""
    units = _without(monkeypatch, hw.cluster, UNITS)
    return Cluster(config=CONFIG), units


@pytest.fixture
def blocks(monkeypatch):
    """An engine, and its blocks by name, the last one of its clusters among them."""
    return Engine(config=CONFIG), _without(monkeypatch, hw.engine, (*BLOCKS, "Cluster"))


def simulate(dut, bench):
    """Run a testbench."""
    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


@pytest.fixture(scope="module")
def given():
    made = case("cornell", rays=(64, 16), cell=0.25)
    plan = schedule(made.record, made.geometry, made.shelling.table, CONFIG, clusters=2, ratio=16)
    image = machine_image(made.record, made.geometry, made.shelling.table, CONFIG, plan,
                          weights=Hemisphere(64, 16).polar_weights)
    assert len(image.subshells(0)) != len(image.subshells(1)) > 0
    return made, image, plan.partition.sections


def test_units_begin_with_what_was_loaded(cluster, given):
    (dut, units), (made, image, sections) = cluster, given
    memory, intersection, traversal = (units[name] for name in UNITS)
    shape, found = ControlFormats(CONFIG).load_word, {}

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
        ctx.set(dut.i_cast.valid, 1)
        for port in memory.i_start, intersection.i_frustum, traversal.i_frustum:
            ctx.set(port.ready, 1)
        for _ in range(LIMIT):
            for name, port in ("intersection", intersection.i_frustum), ("traversal", traversal.i_frustum):
                if ctx.get(port.valid):
                    found[name] = unpack(port.payload.shape(), ctx.get(port.payload.as_value()))
            await ctx.tick()
            ctx.set(dut.i_cast.valid, 0)
        found["sections"] = unpack(dut.sections.shape(), ctx.get(dut.sections.as_value()))

    simulate(dut, bench)
    frustum = frustum_payload(made.record, sections[1], CONFIG)
    assert found["intersection"] == frustum
    assert found["sections"][0] == frustum["section"]
    assert found["traversal"] == {
        "traversal": {"frustum": frustum, "to_global": made.record.to_global.tolist(),
                      "grid_origin": made.shelling.table.position(made.record.origin).tolist(),
                      "cells": made.shelling.table.shape.tolist()},
        "last_shell": made.shelling.cluster(made.record, sections[1]).traversal.last_shell,
        "subshells": {"first": 0, "count": len(image.subshells(1)), "patches": SCENE["patches"]}}


@pytest.mark.parametrize(("command", "kind"), [("loading", "read"), ("casting", "read"), ("writing", "write")])
def test_a_command_keeps_the_window_with_which_it_begins(blocks, command, kind):
    dut, units = blocks
    found = []

    async def bench(ctx):
        registers, control, port = (units[name] for name in BLOCKS[:3])
        windows = {name: (getattr(port, f"{name}_window"), getattr(registers, f"{name}_base"),
                          getattr(registers, f"{name}_limit")) for name in ("read", "write")}
        for step in 1, 2, 3:
            for number, (_, base, limit) in enumerate(windows.values()):
                ctx.set(base, step << 40 | number)
                ctx.set(limit, step << 50 | number)
            ctx.set(getattr(control, command), step == 2)
            await ctx.tick()
        found.extend((name, ctx.get(window.base), ctx.get(window.limit)) for name, (window, *_) in windows.items())

    simulate(dut, bench)
    number = ("read", "write").index(kind)
    assert found[number] == (kind, 2 << 40 | number, 2 << 50 | number)
    assert found[1 - number][1:] == (0, 0)


def test_a_stop_ends_what_memory_has_accepted_and_nothing_else(blocks):
    """Whatever the blocks in reset show: replies are taken and given to nobody, outstanding beats write no byte."""
    dut, units = blocks

    async def bench(ctx):
        control, port, preload, write = (units[name] for name in ("EngineControl", "MainMemoryPort", "PreloadDma",
                                                                  "WriteDma"))
        interface, every = units["SystemBusInterface"], (1 << CONFIG.memory.beat_bytes) - 1
        for stream in write.o_request, port.o_read, port.o_written, preload.o_request:
            ctx.set(stream.valid, 1)
        ctx.set(write.o_data.payload.strobe, every)
        for stops in 0, 1:
            ctx.set(control.stops, stops)
            for is_preload in 0, 1:
                ctx.set(port.o_read.payload.tag, READERS if is_preload else 0)
                assert ctx.get(port.o_read.ready) == stops
                assert ctx.get(preload.i_reply.valid) == (is_preload and not stops)
                assert ctx.get(interface.i_reply.valid) == (not is_preload and not stops)
            assert ctx.get(port.i_write_data.valid) == stops
            assert ctx.get(port.i_write_data.payload.strobe) == (0 if stops else every)
            assert ctx.get(port.o_written.ready) == stops
            assert ctx.get(write.i_written.valid) == (not stops)
            await ctx.tick()
            # The request that was merged before the stop is not passed on.
            assert ctx.get(port.i_read.valid) == ctx.get(port.i_write.valid) == (not stops)

    simulate(dut, bench)
