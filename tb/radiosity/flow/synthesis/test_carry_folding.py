"""LUTs folded into carry cells: sums and carries are the same for all values."""

import copy
import json
import random
from itertools import product

import pytest
from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from radiosity.flow.synthesis import carry_folding, flow
from radiosity.flow.synthesis.carry_folding import fold

PINS = "ABCD"
# Yosys' table of an adder's bit: A + (B xor C), with D = 1.
ADDER = f"{0x96AA:016b}"


def lut(table, nets, output):
    return {"type": "LUT4", "parameters": {"INIT": f"{table:016b}"},
            "port_directions": dict.fromkeys(PINS, "input") | {"Z": "output"},
            "connections": {pin: [net] for pin, net in zip(PINS, nets, strict=True)} | {"Z": [output]}}


def carry(first, second, *, carry_in="0", outputs, tables=(ADDER, ADDER), injects=("NO", "NO")):
    """A carry cell; ``outputs`` are S0, S1 and COUT."""
    return {"type": "CCU2C", "parameters": {"INIT0": tables[0], "INIT1": tables[1],
                                            "INJECT1_0": injects[0], "INJECT1_1": injects[1]},
            "port_directions": {pin + half: "input" for pin in PINS for half in "01"}
            | {"CIN": "input", "S0": "output", "S1": "output", "COUT": "output"},
            "connections": {pin + "0": [net] for pin, net in zip(PINS, first, strict=True)}
            | {pin + "1": [net] for pin, net in zip(PINS, second, strict=True)}
            | {"CIN": [carry_in]} | {pin: [net] for pin, net in zip(("S0", "S1", "COUT"), outputs, strict=True)}}


def module(inputs, outputs, **cells):
    return {"ports": {"i": {"direction": "input", "bits": inputs}, "o": {"direction": "output", "bits": outputs}},
            "cells": cells}


def evaluated(netlist, inputs):
    """The bits of all nets, by Lattice's rules of both cells, from those of the inputs."""
    bits = {"0": 0, "1": 1, "x": 0} | inputs
    pending = [cell for cell in netlist["cells"].values() if cell["type"] in ("LUT4", "CCU2C")]
    while pending:
        left = []
        for cell in pending:
            pins = {pin: net[0] for pin, net in cell["connections"].items()}
            if any(pins[pin] not in bits for pin, way in cell["port_directions"].items() if way == "input"):
                left.append(cell)
                continue
            if cell["type"] == "LUT4":
                bits[pins["Z"]] = entry(cell["parameters"]["INIT"], *(bits[pins[pin]] for pin in PINS))
                continue
            chain = bits[pins["CIN"]]
            for half in "01":
                at = [bits[pins[pin + half]] for pin in PINS]
                propagate = entry(cell["parameters"][f"INIT{half}"], *at)
                injects = cell["parameters"][f"INJECT1_{half}"] == "YES"
                generate = 0 if injects else entry(cell["parameters"][f"INIT{half}"], at[0], at[1], 0, 0)
                bits[pins[f"S{half}"]] = propagate ^ (0 if injects else chain)
                chain = chain if propagate else generate
            bits[pins["COUT"]] = chain
        assert len(left) < len(pending), "the netlist has a loop"
        pending = left
    return bits


def entry(table, a, b, c, d):
    return int(table, 2) >> (a | b << 1 | c << 2 | d << 3) & 1


def outputs_of(netlist):
    """The outputs for all values of the inputs."""
    inputs, outputs = (netlist["ports"][port]["bits"] for port in "io")
    for values in product((0, 1), repeat=len(inputs)):
        bits = evaluated(netlist, dict(zip(inputs, values, strict=True)))
        yield [bits[bit] for bit in outputs]


def folded(netlist):
    after = copy.deepcopy(netlist)
    gone = fold(after)
    assert len(netlist["cells"]) - len(after["cells"]) == gone
    return after, gone


A, B, C, S, X, Y, CIN = range(2, 9)
FRONT, OTHER, SUM, SUM1, CARRY = range(10, 15)
XOR, AND, MUX = 0b0110_0110_0110_0110, 0b1000_1000_1000_1000, 0b1100_1010_1100_1010
OPEN = ("0", "0", "0", "1")


@pytest.mark.parametrize(("table", "front", "gone"), [
    # B xor S, B and S, C ? B : S, each in front of an adder.
    (XOR, (B, S, "0", "0"), 1), (AND, (B, S, "1", "0"), 1), (MUX, (X, Y, S, "0"), 1),
    # The LUT also reads the adder's other operand.
    (XOR, (A, S, "0", "0"), 1),
    # Five inputs.
    (0x6996, (B, C, X, Y), 0)])
@pytest.mark.parametrize("half", [0, 1])
def test_an_operand_folds_if_four_inputs_are_enough(table, front, gone, half):
    operands = [OPEN, OPEN]
    operands[half] = (A, FRONT, "0", "1")
    netlist = module([A, B, C, S, X, Y, CIN], [SUM, SUM1, CARRY], front=lut(table, front, FRONT),
                     adder=carry(*operands, carry_in=CIN, outputs=(SUM, SUM1, CARRY)))
    after, found = folded(netlist)
    assert found == gone
    assert list(outputs_of(after)) == list(outputs_of(netlist))


def test_a_carry_that_four_inputs_cannot_make_stays():
    """A + (B xor C xor S): with C = D = 0 the carry's table is A xor B, as the sum's, and not A."""
    netlist = module([A, B, C, S, CIN], [SUM, SUM1, CARRY], front=lut(0x9696, (B, C, S, "0"), FRONT),
                     adder=carry((A, FRONT, "0", "1"), OPEN, carry_in=CIN, outputs=(SUM, SUM1, CARRY)))
    assert folded(netlist) == (netlist, 0)


def test_a_lut_that_something_else_reads_stays():
    front = lut(XOR, (B, S, "0", "0"), FRONT)
    adder = carry((A, FRONT, "0", "1"), OPEN, carry_in=CIN, outputs=(SUM, SUM1, CARRY))
    assert folded(module([A, B, S, CIN], [SUM, CARRY, FRONT], front=front, adder=adder))[1] == 0
    reader = lut(XOR, (FRONT, X, "0", "0"), OTHER)
    assert folded(module([A, B, S, X, CIN], [SUM, CARRY, OTHER], front=front, adder=adder, reader=reader))[1] == 0
    first = carry((A, B, "0", "1"), OPEN, carry_in=FRONT, outputs=(SUM, SUM1, CARRY))
    assert folded(module([A, B, S], [SUM, CARRY], front=front, adder=first))[1] == 0
    injected = carry((FRONT, A, "0", "1"), OPEN, carry_in=CIN, outputs=(SUM, SUM1, CARRY), injects=("YES", "NO"))
    assert folded(module([A, B, S, CIN], [SUM, CARRY], front=front, adder=injected))[1] == 0


def test_a_lut_of_several_adders_folds_into_all_or_none():
    front = lut(XOR, (B, S, "0", "0"), FRONT)
    fits = carry((A, FRONT, "0", "1"), (FRONT, C, "0", "1"), carry_in=CIN, outputs=(SUM, SUM1, CARRY))
    netlist = module([A, B, C, S, CIN], [SUM, SUM1, CARRY], front=front, adder=fits)
    after, gone = folded(netlist)
    assert gone == 1
    assert list(outputs_of(after)) == list(outputs_of(netlist))
    # The second one has three other inputs.
    full = carry((A, X, Y, FRONT), OPEN, carry_in=CIN, outputs=(OTHER, 20, 21))
    assert folded(module([A, B, C, S, X, Y, CIN], [SUM, CARRY, OTHER], front=front, adder=fits, full=full))[1] == 0


def test_luts_in_a_row_fold():
    netlist = module([A, B, S, CIN], [SUM, SUM1, CARRY], first=lut(0x5555, (B, "0", "0", "0"), OTHER),
                     second=lut(AND, (OTHER, S, "0", "0"), FRONT),
                     adder=carry((A, FRONT, "0", "1"), OPEN, carry_in=CIN, outputs=(SUM, SUM1, CARRY)))
    after, gone = folded(netlist)
    assert gone == 2
    assert list(outputs_of(after)) == list(outputs_of(netlist))


def drawn(rng):
    """Random LUTs in front of random halves, adders among them."""
    nets = [A, B, C, S, X]
    cells = {f"front_{k}": lut(rng.getrandbits(16), rng.choices([*nets, "0", "1"], k=4), FRONT + k) for k in range(3)}
    halves = [rng.choices([*nets[:2], FRONT, FRONT + 1, FRONT + 2, "0", "1"], k=4) for _ in range(2)]
    tables = [rng.choice([ADDER, f"{rng.getrandbits(16):016b}"]) for _ in range(2)]
    return module([*nets, CIN], [20, 21, 22], **cells,
                  adder=carry(*halves, carry_in=CIN, outputs=(20, 21, 22), tables=tables))


def test_drawn_netlists_have_the_same_outputs():
    rng, gone = random.Random(1), 0
    for _ in range(300):
        netlist = drawn(rng)
        after, found = folded(netlist)
        assert list(outputs_of(after)) == list(outputs_of(netlist))
        gone += found
    assert gone > 100


def test_a_carry_that_is_not_composed_would_be_noticed(monkeypatch):
    """The same netlists, with a fold that composes the sum alone."""
    table = carry_folding._table
    monkeypatch.setattr(carry_folding, "_table", lambda rows, order: table([(*row[:2], 0) for row in rows], order))
    rng = random.Random(1)
    netlists = [drawn(rng) for _ in range(50)]
    assert any(list(outputs_of(folded(netlist)[0])) != list(outputs_of(netlist)) for netlist in netlists)


class Operands(wiring.Component):
    """Adders with the operands that the machine's have: subtracted on demand, selected, masked."""

    def __init__(self):
        super().__init__({"a": In(8), "b": In(8), "c": In(8), "s": In(1), "o_sum": Out(9), "o_chosen": Out(9),
                          "o_masked": Out(9)})

    def elaborate(self, platform):
        m = Module()
        inverted = Signal(8)
        m.d.comb += [inverted.eq(self.b ^ self.s.replicate(8)), self.o_sum.eq(self.a + inverted + self.s),
                     self.o_chosen.eq(self.a + Mux(self.s, self.b, self.c)),
                     self.o_masked.eq(self.a - (self.c & self.s.replicate(8)))]
        return m


def test_adders_of_the_mapper_fold(tmp_path):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(flow, "fold", lambda module: 0)
        mapped = flow.synthesise(Operands(), tmp_path)
    netlist = json.loads((tmp_path / "area.json").read_text())["modules"]["top"]
    after, gone = folded(netlist)
    # Each bit of three operands.
    assert gone >= 3 * 8
    area = flow.synthesise(Operands(), tmp_path / "folded")
    assert (area.folded, area.lut) == (gone, mapped.lut - gone)
    rng = random.Random(1)
    ports = netlist["ports"].values()
    for _ in range(300):
        inputs = {bit: rng.randrange(2) for port in ports if port["direction"] == "input" for bit in port["bits"]}
        before, now = evaluated(netlist, inputs), evaluated(after, inputs)
        assert all(before[bit] == now[bit] for port in ports if port["direction"] == "output" for bit in port["bits"])
