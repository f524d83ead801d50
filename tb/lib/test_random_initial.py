"""A small export with random initial values: what a reset sets begins there, the rest begins with anything."""

import re

import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from radiosity.flow.verilog.export import verilog_of
from tb.lib.random_initial import with_random_initial_values


class Registers(wiring.Component):
    """Registers, a table and a memory."""

    def __init__(self):
        super().__init__({"i": In(40), "o": Out(40)})

    def elaborate(self, platform):
        """Each is read."""
        m = Module()
        number, table, memory = Signal(32), Memory(shape=8, depth=64, init=range(1, 65)), Memory(
            shape=40, depth=64, init=[])
        m.submodules.table, m.submodules.memory = table, memory
        write, read, known = memory.write_port(), memory.read_port(domain="comb"), table.read_port(domain="comb")
        m.d.comb += [write.addr.eq(self.i), write.data.eq(self.i), write.en.eq(1), read.addr.eq(number),
                     known.addr.eq(number)]
        m.d.sync += [number.eq(self.i), self.o.eq(read.data + known.data)]
        return m


def values(text):
    """Initial values of registers, the words of the table, and what the memory begins with."""
    return (dict(re.findall(r"(?m)^  reg (?:\[\d+:0\] )?(\S+) += (.*);", text)),
            re.findall(r"(?m)^ +table\S* *\[\d+\] = .*;", text), re.findall(r"(?m)^ +for .*memory.* = (.*);", text))


@pytest.mark.parametrize("seed", [1, 2])
def test_all_but_tables_begins_with_random_values(seed):
    text = verilog_of(Registers(), "top")
    (registers, table, memory), (drawn, same, filled) = (values(one) for one in (
        text, with_random_initial_values(text, seed)))
    assert {*registers} == {*drawn}
    assert len(registers) == 2
    assert not {*registers.items()} & {*drawn.items()}
    assert table == same
    assert len(memory) == len(filled) == 1
    assert memory != filled
    assert with_random_initial_values(text, seed) == with_random_initial_values(text, seed)
    assert with_random_initial_values(text, seed + 1) != with_random_initial_values(text, seed)
