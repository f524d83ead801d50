"""A cluster's connections, around units that do nothing: each unit is given what was loaded for it."""

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.sim import Simulator

import hw.cluster
from golden.config import PRESETS
from golden.frustum import Hemisphere
from golden.memory_map import machine_image
from golden.schedule.phase import schedule
from hw.cluster import Cluster
from hw.control.control_formats import ControlFormats
from hw.lib.inspection import inspect
from tb.control.image_words import words
from tb.golden.schedule.scenes import case
from tb.icu.frustum_load import frustum_payload
from tb.lib.payload import pack, unpack

CONFIG = PRESETS["tiny"].replace({"ctu.subshell_bits": 10, "noc.columns": 2, "noc.rows": 1})
UNITS = ("MemorySystem", "IntersectionUnit", "TraversalUnit")
# No two of them are the same.
SCENE = {"cells": 700, "lists": 1234, "patches": 300}
LIMIT = 100


class _Unit(wiring.Component):
    """The ports of a unit."""

    def elaborate(self, platform):
        return Module()


@pytest.fixture
def cluster(monkeypatch):
    """Cluster 1 of two, and its units by name."""
    units = {}

    def replace(name, real):
        def make(**given):
            units[name] = _Unit(inspect(lambda: real(**given), lambda unit: unit.signature))
            return units[name]

        monkeypatch.setattr(hw.cluster, name, make)

    for name in UNITS:
        replace(name, getattr(hw.cluster, name))
    return Cluster(config=CONFIG), units


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

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    frustum = frustum_payload(made.record, sections[1], CONFIG)
    assert found["intersection"] == frustum
    assert found["sections"][0] == frustum["section"]
    assert found["traversal"] == {
        "traversal": {"frustum": frustum, "to_global": made.record.to_global.tolist(),
                      "grid_origin": made.shelling.table.position(made.record.origin).tolist(),
                      "cells": made.shelling.table.shape.tolist()},
        "last_shell": made.shelling.cluster(made.record, sections[1]).traversal.last_shell,
        "subshells": {"first": 0, "count": len(image.subshells(1)), "patches": SCENE["patches"]}}
