"""Enables and resets in the global clock network: the right ones, and each register keeps its own."""

import copy
import json

import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from radiosity.flow.synthesis import flow
from radiosity.flow.synthesis.global_nets import LEAST_FAN_OUT, NETS, PINS, globalise

BITS = 6


def netlist(*counts):
    """A module with an enable, and every second time a reset, for so many registers each."""
    cells, bits = {}, 100
    for number, count in enumerate(counts):
        for _ in range(count):
            cells[f"register_{bits}"] = {
                "type": "TRELLIS_FF", "attributes": {}, "connections": {
                    "DI": [bits], "Q": [bits + 1], "CLK": [99],
                    PINS[number % 2]: [number], PINS[1 - number % 2]: ["0"]}}
            bits += 2
    return {"cells": cells, "netnames": {"all": {"bits": list(range(bits))}}}


def pins_of(module):
    """What each register has at its pins, in front of buffers."""
    buffers = {cell["connections"]["CLKO"][0]: cell["connections"]["CLKI"][0] for cell in module["cells"].values()
               if cell["type"] == "DCCA"}
    return {name: [buffers.get(cell["connections"][pin][0], cell["connections"][pin][0]) for pin in PINS]
            for name, cell in module["cells"].items() if cell["type"] == "TRELLIS_FF"}


def sources(module):
    return [cell["connections"]["CLKI"][0] for cell in module["cells"].values() if cell["type"] == "DCCA"]


@pytest.mark.parametrize(("counts", "promoted"), [
    ([LEAST_FAN_OUT - 1], []), ([LEAST_FAN_OUT], [0]),
    ([3, LEAST_FAN_OUT + 1, LEAST_FAN_OUT, LEAST_FAN_OUT + 2], [3, 1, 2]),
    ([LEAST_FAN_OUT + k for k in range(NETS + 2)], [8, 7, 6, 5, 4, 3, 2]), ([LEAST_FAN_OUT] * 3, [0, 1, 2])])
def test_those_with_the_most_registers(counts, promoted):
    module = netlist(*counts)
    before = pins_of(copy.deepcopy(module))
    assert len(globalise(module)) == len(promoted)
    assert sources(module) == promoted
    assert pins_of(module) == before
    # Their own nets, and no other's.
    made = [cell["connections"]["CLKO"][0] for cell in module["cells"].values() if cell["type"] == "DCCA"]
    assert len(set(made) - set(netlist(*counts)["netnames"]["all"]["bits"])) == len(made)


def driven_by_registers(*behind):
    """`netlist` with a reset for each of ``behind``: of a register behind another register, or else behind a LUT."""
    module = netlist(*(LEAST_FAN_OUT + number for number in reversed(range(len(behind)))))
    for number, is_register in enumerate(behind):
        source = 10 + number
        pins = {"DI": [20 + number], "CLK": [99], "CE": ["1"], "LSR": [98]}
        module["cells"][f"driver_{number}"] = {"type": "TRELLIS_FF", "attributes": {"src": "reset"},
                                               "connections": {**pins, "DI": [source], "Q": [number]}}
        module["cells"][f"source_{number}"] = {
            "type": "TRELLIS_FF", "attributes": {}, "connections": {**pins, "Q": [source]}} if is_register else {
            "type": "LUT4", "connections": {"Z": [source]}}
    return module


def test_a_register_behind_another_one_drives_its_buffer_from_beside_it():
    module = driven_by_registers(True, False, True)
    before, names = pins_of(copy.deepcopy(module)), set(module["cells"])
    globalise(module)
    assert set(module["cells"]) - names == {"driver_0_at_buffer", "driver_2_at_buffer", *(
        f"global_{number}" for number in range(3))}
    anchored = [module["cells"][f"driver_{number}_at_buffer"] for number in (0, 2)]
    drivers = [module["cells"][f"driver_{number}"] for number in (0, 2)]
    assert sources(module) == [anchored[0]["connections"]["Q"][0], 1, anchored[1]["connections"]["Q"][0]]
    for one, driver in zip(anchored, drivers, strict=True):
        assert {**one["connections"], "Q": driver["connections"]["Q"]} == driver["connections"]
        assert one["attributes"].pop("BEL").endswith(".FF0")
        assert one["attributes"] == driver["attributes"] == {"src": "reset"}
    copies = {one["connections"]["Q"][0]: driver["connections"]["Q"][0]
              for one, driver in zip(anchored, drivers, strict=True)}
    after = {name: [copies.get(bit, bit) for bit in bits] for name, bits in pins_of(module).items() if name in names}
    assert after == before


def test_no_two_registers_have_one_place():
    module = driven_by_registers(*[True] * NETS)
    globalise(module)
    places = [cell["attributes"]["BEL"] for name, cell in module["cells"].items() if name.endswith("_at_buffer")]
    assert len(set(places)) == len(places) == NETS


class Enabled(wiring.Component):
    """Registers with one enable, which comes out too."""

    def __init__(self):
        super().__init__({"enable": In(2), "i": In(BITS), "o": Out(BITS), "o_enable": Out(1)})

    def elaborate(self, platform):
        m = Module()
        enable, held = Signal(), self.i
        m.d.comb += [enable.eq(self.enable.all()), self.o_enable.eq(enable)]
        with m.If(enable):
            for stage in range(LEAST_FAN_OUT // BITS + 1):
                following = Signal(BITS, name=f"held_{stage}", reset_less=True)
                m.d.sync += following.eq(held ^ (held << 1))
                held = following
        m.d.comb += self.o.eq(held)
        return m


def test_of_a_component(tmp_path):
    flow.synthesise(Enabled(), tmp_path)
    module = json.loads((tmp_path / "area.json").read_text())["modules"]["top"]
    enable, = module["ports"]["o_enable"]["bits"]
    assert sources(module) == [enable], "the port is driven as before, the registers by a buffer"
    assert set(map(tuple, pins_of(module).values())) == {(enable, "0")}
