"""Copies of registers with many readers: every reader sees a register with the same inputs, and none has too many."""

import copy
import json
from collections import Counter

import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hw.synthesis import flow
from hw.synthesis.copied_registers import READERS, copy_registers

_D, _CLOCK, _Q = 2, 3, 4


def netlist(*counts):
    """Registers with so many readers each; the first one drives a port too, and the last one a clock buffer."""
    cells, bits = {}, 10 + len(counts)
    for number, count in enumerate(counts):
        cells[f"register_{number}"] = {
            "type": "TRELLIS_FF", "parameters": {"REGSET": "SET" if number else "RESET"}, "attributes": {},
            "port_directions": {"DI": "input", "CLK": "input", "CE": "input", "Q": "output"},
            "connections": {"DI": [_D], "CLK": [_CLOCK], "CE": ["1"], "Q": [10 + number]}}
        for reader in range(count):
            cells[f"unit_{reader % 3}.reader_{number}_{reader}"] = {
                "type": "LUT4", "parameters": {}, "attributes": {},
                "port_directions": {**dict.fromkeys("ABCD", "input"), "Z": "output"},
                "connections": {"A": [10 + number], "B": ["0"], "C": [_D], "D": [10 + number], "Z": [bits]}}
            bits += 1
    cells["buffer"] = {"type": "DCCA", "parameters": {}, "attributes": {},
                       "port_directions": {"CLKI": "input", "CLKO": "output"},
                       "connections": {"CLKI": [9 + len(counts)], "CLKO": [bits]}}
    return {"cells": cells, "ports": {"o": {"direction": "output", "bits": [10]}},
            "netnames": {"all": {"bits": list(range(bits + 1))}}}


def registers_of(module):
    """By bit the register that drives it, without its output."""
    return {cell["connections"]["Q"][0]: {**cell, "connections": {**cell["connections"], "Q": None}}
            for cell in module["cells"].values() if cell["type"] == "TRELLIS_FF"}


@pytest.mark.parametrize(("counts", "added"), [
    ([READERS // 2], 0), ([READERS // 2 + 1], 1), ([READERS, 1], 1), ([READERS + 1, READERS // 2], 2), ([2, 5 * READERS, 3], 9)])
def test_readers_share_copies(counts, added):
    module = netlist(*counts)
    before, registers = copy.deepcopy(module), registers_of(module)
    assert copy_registers(module) == added
    assert len(registers_of(module)) == len(registers) + added
    for name, cell in before["cells"].items():
        for pin, bits in cell["connections"].items():
            found = module["cells"][name]["connections"][pin]
            assert [registers_of(module).get(bit, bit) for bit in found] == [registers.get(bit, bit) for bit in bits]
    readers = Counter(bit for name, cell in module["cells"].items() if cell["type"] == "LUT4"
                      for pin in "ABCD" for bit in cell["connections"][pin])
    assert max(readers[bit] for bit in registers_of(module)) <= READERS
    assert module["ports"] == before["ports"], "the port has the register itself"
    assert module["cells"]["buffer"] == before["cells"]["buffer"], "and so has the global network"


def test_neighbours_have_the_same_copy():
    module = netlist(3 * READERS // 2)
    copy_registers(module)
    drivers = {}
    for name, cell in module["cells"].items():
        if cell["type"] == "LUT4":
            drivers.setdefault(cell["connections"]["A"][0], set()).add(name.split(".")[0])
    assert sorted(map(sorted, drivers.values())) == [["unit_0"], ["unit_1"], ["unit_2"]]


class Selected(wiring.Component):
    """A select of many multiplexers, which comes out too."""

    def __init__(self):
        width = 2 * READERS + 1
        super().__init__({"select": In(1), "a": In(width), "b": In(width), "o": Out(width), "o_select": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.d.sync += self.o_select.eq(self.select)
        with m.If(self.o_select):
            m.d.comb += self.o.eq(self.a)
        with m.Else():
            m.d.comb += self.o.eq(self.b)
        return m


def test_of_a_component(tmp_path):
    flow.synthesise(Selected(), tmp_path)
    module = json.loads((tmp_path / "area.json").read_text())["modules"]["top"]
    found = registers_of(module)
    assert len(found) == 3
    assert len({json.dumps(register, sort_keys=True) for register in found.values()}) == 1
    selects = Counter(bit for cell in module["cells"].values() if cell["type"] != "TRELLIS_FF"
                      for bits in cell["connections"].values() for bit in bits if bit in found)
    assert max(selects.values()) <= READERS
