"""Copies of registers and LUTs with many readers: each reader has the same function at its pin, no driver too many."""

import copy
import json
from collections import Counter

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from radiosity.flow.synthesis import flow
from radiosity.flow.synthesis.copied_drivers import MOST_FAN_OUT, MOST_MULTIPLIERS, copy_drivers

_D, _CLOCK = 2, 3
_OUTPUTS = {"TRELLIS_FF": "Q", "LUT4": "Z", "DCCA": "CLKO"}


def cell(kind, **connections):
    outputs = _OUTPUTS.get(kind)
    return {"type": kind, "parameters": {"INIT": "0110"}, "attributes": {},
            "port_directions": {pin: "output" if pin == outputs else "input" for pin in connections},
            "connections": {pin: [bit] for pin, bit in connections.items()}}


def netlist(*counts, kind="TRELLIS_FF"):
    """Drivers with so many readers each; the first one drives a port too, and the last one a clock buffer."""
    cells, bits = {}, 10 + len(counts)
    for number, count in enumerate(counts):
        if kind == "LUT4":
            cells[f"driver_{number}"] = cell(kind, A=_D, B=4 + number % 2, C="0", D="1", Z=10 + number)
        else:
            cells[f"driver_{number}"] = cell(kind, DI=_D, CLK=_CLOCK, CE="01"[number % 2], Q=10 + number)
        for reader in range(count):
            cells[f"unit_{reader % 3}.reader_{number}_{reader}"] = cell(
                "LUT4", A=10 + number, B="0", C=_D, D=10 + number, Z=bits)
            bits += 1
    cells["buffer"] = cell("DCCA", CLKI=9 + len(counts), CLKO=bits)
    cells["multiplexer"] = cell("PFUMX", ALUT=9 + len(counts), BLUT=10, C0=_D)
    return {"cells": cells, "ports": {"o": {"direction": "output", "bits": [10]}},
            "netnames": {"all": {"bits": list(range(bits + 1))}}}


def functions_of(module):
    """By bit the cell that drives it, without its output."""
    return {found["connections"][output][0]: {**found, "connections": {**found["connections"], output: None}}
            for found in module["cells"].values() if (output := _OUTPUTS.get(found["type"]))}


@pytest.mark.parametrize("kind", ["TRELLIS_FF", "LUT4"])
@pytest.mark.parametrize(("counts", "added"), [
    ([MOST_FAN_OUT // 2], 0), ([MOST_FAN_OUT // 2 + 1], 1), ([MOST_FAN_OUT, 1], 1),
    ([MOST_FAN_OUT + 1, MOST_FAN_OUT // 2], 2), ([2, 5 * MOST_FAN_OUT, 3], 9)])
def test_readers_share_copies(counts, added, kind):
    module = netlist(*counts, kind=kind)
    before, functions = copy.deepcopy(module), functions_of(module)
    assert copy_drivers(module) == {"LUT4": 0, "TRELLIS_FF": 0} | {kind: added}
    after = functions_of(module)
    assert len(after) == len(functions) + added
    drivers = {bit for bit in after if bit < 10 + len(counts)} | set(after).difference(functions)
    for name, found in before["cells"].items():
        for pin, (bit,) in found["connections"].items():
            now, = module["cells"][name]["connections"][pin]
            assert now == bit or (now in drivers and after[now] == functions[bit])
    readers = Counter(bit for found in module["cells"].values() if found["type"] == "LUT4"
                      for pin in "ABCD" for bit in found["connections"][pin])
    assert max(readers[bit] for bit in drivers) <= MOST_FAN_OUT
    assert module["ports"] == before["ports"], "the port has the driver itself"
    for fixed in "buffer", "multiplexer":
        assert module["cells"][fixed] == before["cells"][fixed], "and so has what is bound to its place"


@pytest.mark.parametrize(("count", "added"), [(MOST_MULTIPLIERS, 0), (MOST_MULTIPLIERS + 1, 1), (11, 2)])
def test_few_multipliers_share_a_copy(count, added):
    """A multiplier counts once, whichever of its pins read the register."""
    module = netlist(0)
    module["cells"] |= {f"product_{number}": cell("MULT18X18D", A0=10, B0=10) for number in range(count)}
    functions = functions_of(module)
    assert copy_drivers(module) == {"LUT4": 0, "TRELLIS_FF": added}
    after, readers = functions_of(module), Counter()
    for number in range(count):
        pins = module["cells"][f"product_{number}"]["connections"]
        readers.update({bit for pin in ("A0", "B0") for bit in pins[pin]})
        assert all(after[bit] == functions[10] for pin in ("A0", "B0") for bit in pins[pin])
    assert max(readers.values()) <= MOST_MULTIPLIERS
    assert len(readers) == added + 1


def test_neighbours_have_the_same_copy():
    module = netlist(3 * MOST_FAN_OUT // 2)
    copy_drivers(module)
    drivers = {}
    for name, found in module["cells"].items():
        if name.startswith("unit"):
            drivers.setdefault(found["connections"]["A"][0], set()).add(name.split(".")[0])
    assert sorted(map(sorted, drivers.values())) == [["unit_0"], ["unit_1"], ["unit_2"]]


def test_copies_of_a_lut_share_copies_of_its_register():
    module = netlist(MOST_FAN_OUT * MOST_FAN_OUT, kind="LUT4")
    module["cells"]["register"] = cell("TRELLIS_FF", DI=_D, CLK=_CLOCK, CE="1", Q=4)
    assert copy_drivers(module) == {"LUT4": 2 * MOST_FAN_OUT - 1, "TRELLIS_FF": 1}


class Selected(wiring.Component):
    """A select of many multiplexers, which comes out too."""

    def __init__(self):
        width = 2 * MOST_FAN_OUT + 1
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
    found = {bit: function for bit, function in functions_of(module).items() if function["type"] == "TRELLIS_FF"}
    assert len(found) == 3
    assert len({json.dumps(register, sort_keys=True) for register in found.values()}) == 1
    selects = Counter(bit for reader in module["cells"].values() if reader["type"] == "LUT4"
                      for bits in reader["connections"].values() for bit in bits if bit in found)
    assert max(selects.values()) <= MOST_FAN_OUT
