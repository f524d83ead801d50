"""Latencies that a manifest gives are those of all instances of a unit."""

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring

from radiosity.flow.package.unit_latencies import unit_latencies


class Unit(wiring.Component):
    """A unit of a block, with parts inside it."""

    def __init__(self, latency, *parts):
        super().__init__({})
        self.parts = parts
        if latency is not None:
            self.latency = latency

    def elaborate(self, platform):
        m = Module()
        m.submodules += self.parts
        return m


def kind(name, module):
    return type(name, (Unit,), {"__module__": module})


Filter, Table = kind("Filter", "hw.memsys.patches.filter"), kind("Table", "hw.ctu.table")
Buffer, Silent = kind("Buffer", "hw.lib.buffer"), kind("Silent", "hw.icu.silent")


@pytest.mark.parametrize(("latencies", "expected"), [
    ((3, 3, 3), {"memsys.Filter": 3}), ((3, 3, 4), {}), ((4, 3, 3), {}), ((0, 0, 0), {"memsys.Filter": 0}),
    ((0, 3, None), {}), ((None, 3, 3), {"memsys.Filter": 3}), ((None, None, None), {})])
def test_a_unit_has_a_latency_if_its_instances_share_one(latencies, expected):
    """Beside each other, inside each other, and in several components."""
    one, two, three = latencies
    for tops in ([Filter(one), Filter(two), Filter(three)], [Table(7, Filter(one, Filter(two)), Filter(three))],
                 [Table(7, Filter(one)), Table(7, Buffer(2, Filter(two)), Silent(None, Filter(three)))]):
        tables = {"ctu.Table": 7} if isinstance(tops[0], Table) else {}
        assert unit_latencies(*tops) == tables | expected
