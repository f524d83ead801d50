from functools import partial

import pytest
from amaranth.hdl import Module, ResetSignal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.cluster import Cluster
from hw.engine import Engine
from hw.lib.skid_buffer import SkidBuffer
from tb.docs.structure import SELF, Block, Link, Store, structures
from tb.docs.tiny_structures import tiny_structures

# Looks at what tb/docs/test_architecture.py looks at.
pytestmark = pytest.mark.xdist_group("structures")


class Toy(wiring.Component):
    """Two buffers, the second of which gets the first one's items changed, a cycle later, or not at all."""

    def __init__(self, *, way):
        self._way = way
        super().__init__({"i": In(stream.Signature(8)), "o": Out(stream.Signature(8)), "level": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.first, m.submodules.second = first, second = SkidBuffer(8), SkidBuffer(8)
        m.submodules.memory = Memory(shape=4, depth=16, init=[])
        wiring.connect(m, wiring.flipped(self.i), first.i)
        wiring.connect(m, second.o, wiring.flipped(self.o))
        if self._way == "changed":
            m.d.sync += second.i.payload.eq(first.o.payload + 1)
        elif self._way == "in reset":
            m.d.comb += second.i.valid.eq(ResetSignal() | first.o.valid)
        elif self._way == "offered":
            m.d.comb += second.i.valid.eq(first.o.valid & self.i.valid)
        elif self._way == "accepted":
            # Only reports when the other one takes something.
            m.d.comb += second.i.valid.eq(first.i.ready)
        return m


# Of each way the streams that there are beside the two of all.
WAYS = {"changed": {("first", "second")}, "in reset": {("first", "second")},
        "offered": {("first", "second"), (SELF, "second")}, "accepted": set(), "none": set()}


def edges(structure):
    return {(link.source, link.sink) for link in structure.links if link.kind != "signal"}


def test_streams_connect_where_items_or_offers_flow():
    toys = {way: type(way, (Toy,), {}) for way in WAYS}
    found = structures([partial(toys[way], way=way) for way in WAYS], whole=False)
    assert {way: edges(found[toy]) for way, toy in toys.items()} == {
        way: {(SELF, "first"), ("second", SELF)} | more for way, more in WAYS.items()}


def test_ports_blocks_and_memories():
    found = structures([lambda: Toy(way="changed")])[Toy]
    assert [(port.path, port.is_input, port.kind, port.bits) for port in found.ports] == [
        ("i", True, "stream", 8), ("o", False, "stream", 8), ("level", False, "signal", 1)]
    assert found.blocks == (Block("first", SkidBuffer), Block("second", SkidBuffer))
    assert found.stores == (Store("memory", 16, 4),)
    assert Link("first", "o", "second", "i", "stream") in found.links


def test_streams_of_the_cluster():
    assert {("traversal", "cells"), ("cells", "memory"), ("memory", "merged"), ("merged", "intersection"),
            ("intersection", "traversal"), ("traversal", "intersection"), ("tables", "memory"), ("load", "entries"),
            ("entries", "intersection"), (SELF, "slot"), ("slot", "control"), ("control", "traversal"),
            ("control", "results"), ("results", "writer"), ("intersection", "writer"), ("writer", SELF)} <= (
                found := edges(tiny_structures()[Cluster]))
    assert not {("intersection", "memory"), ("memory", "control"), ("intersection", SELF)} & found


def test_streams_of_the_engine():
    found = edges(tiny_structures()[Engine])
    assert {(SELF, "registers"), ("registers", "control"), ("port", SELF), ("port", "interface"), ("port", "preload"),
            ("port", "fetch"), ("fetch", "dispatch"), ("dispatch", "cluster_1"), ("cluster_0", "completions"),
            ("cluster_0", "writes"), ("completions", "writes"), ("writes", "port"), ("cluster_0", "bus"),
            ("bus", "cluster_1"), ("cluster_1", "network"), ("network", "cluster_0")} <= found
    assert not {("cluster_0", "cluster_1"), ("interface", "port"), ("fetch", "cluster_0")} & found
