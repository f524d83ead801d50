"""The netlist, as it is placed, does what the description says."""

import json
import random
import re
from pathlib import Path

import cocotb
import pytest
from amaranth.hdl import Module, Signal, Value, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator
from cocotb.triggers import FallingEdge, RisingEdge, Timer

from hw.lib.shared_port import share_port
from tb.lib.clocking import start
from tb.lib.runner import SIMULATORS, Simulation, options
from tb.radiosity.flow.synthesis.mapped import mapped_text

MODULE = "tb.radiosity.flow.synthesis.test_mapped"
pytestmark = pytest.mark.sim
# Bits and words of one block RAM, or of distributed memory, and how many bits are written together.
SHAPES = ((1, 1 << 14, 1), (2, 1 << 13, 2), (4, 1 << 12, 4), (9, 1 << 11, 9), (18, 1 << 10, 9), (36, 512, 9), (6, 8, 6))
WIDEST, DEEPEST, OPERAND = 36, 1 << 14, 13


class Cells(wiring.Component):
    """Memories of each shape, products with registers that go into them, and registers that begin with ones."""

    def __init__(self):
        super().__init__({
            "read_address": In(range(DEEPEST)), "write": In(range(DEEPEST)), "enable": In(4), "data": In(WIDEST),
            "go": In(1), "a": In(signed(OPERAND)), "b": In(OPERAND), "o_read": Out(WIDEST).array(len(SHAPES)),
            "o_through": Out(18), "o_first": Out(18), "o_second": Out(18), "o_apart": Out(18),
            "o_product": Out(signed(2 * OPERAND)), "o_held": Out(2 * OPERAND), "o_ones": Out(WIDEST)})

    def elaborate(self, platform):
        m = Module()
        for number, (width, depth, together) in enumerate(SHAPES):
            m.submodules[f"memory_{number}"] = memory = Memory(shape=width, depth=depth, init=first(number))
            write, read = memory.write_port(granularity=together), memory.read_port()
            m.d.comb += [write.addr.eq(self.write), write.data.eq(self.data), write.en.eq(self.enable),
                         read.addr.eq(self.read_address), read.en.eq(self.go), self.o_read[number].eq(read.data)]
        m.submodules.through = through = Memory(shape=18, depth=1024, init=first(4))
        write = through.write_port()
        read = through.read_port(transparent_for=[write])
        m.d.comb += [write.addr.eq(self.write), write.data.eq(self.data), write.en.eq(self.enable[0]),
                     read.addr.eq(self.read_address), read.en.eq(self.go), self.o_through.eq(read.data)]
        # Written at the second reader's port, whose address is then the other one's.
        m.submodules.shared = shared = Memory(shape=18, depth=1024, init=first(4))
        readers = [shared.read_port() for _ in range(2)]
        for reader, found in zip(readers, (self.o_first, self.o_second), strict=True):
            m.d.comb += [reader.addr.eq(self.read_address), found.eq(reader.data)]
        share_port(readers[1], m, shared.write_port(), enable=self.enable[0], address=self.write, data=self.data)
        # With registers behind it, and never read where it is written.
        m.submodules.apart = apart = Memory(shape=18, depth=1024, init=first(4), attrs={"no_rw_check": 1})
        write, read = apart.write_port(), apart.read_port()
        m.d.comb += [write.addr.eq(self.write), write.data.eq(self.data), read.addr.eq(self.read_address),
                     write.en.eq(self.enable[0] & (self.write[:10] != self.read_address[:10]))]
        a, b = (Signal(signed(OPERAND), name=name, reset_less=True) for name in ("left", "right"))
        c, d = (Signal(OPERAND, name=name, reset_less=True) for name in ("height", "width"))
        word, product = Signal(18, reset_less=True), Signal(signed(2 * OPERAND), reset_less=True)
        held, ones = Signal(2 * OPERAND, reset_less=True), Signal(WIDEST, reset_less=True, init=(1 << WIDEST) - 1)
        m.d.sync += [a.eq(self.a), b.eq(self.b), product.eq(a * b), c.eq(self.a), d.eq(self.b)]
        with m.If(self.go):
            m.d.sync += [word.eq(read.data), held.eq(c * d), ones.eq(ones ^ self.data)]
        m.d.comb += [self.o_apart.eq(word), self.o_product.eq(product), self.o_held.eq(held),
                     self.o_ones.eq(ones)]
        return m


def first(number):
    """What a memory begins with."""
    width, depth, _ = SHAPES[number]
    draw = random.Random(number)
    return [draw.getrandbits(width) for _ in range(depth)]


def stimulus(count=800):
    """First what the memories begin with is read; then addresses are few, so that what is read is written too, in the
    same cycle as well.
    """
    draw = random.Random(1)
    for cycle in range(count):
        if cycle % 100 == 0:
            addresses = [draw.randrange(DEEPEST) for _ in range(6)]
        begins = cycle < count // 4
        yield {"read_address": draw.randrange(DEEPEST) if begins else draw.choice(addresses),
               "write": draw.choice(addresses),
               "enable": 0 if begins else draw.choice((0, 0, 15, draw.randrange(16))), "data": draw.getrandbits(WIDEST),
               "go": int(draw.random() < 0.8), "a": draw.getrandbits(OPERAND), "b": draw.getrandbits(OPERAND)}


def outputs(component):
    """By name, of flat ones."""
    return {"__".join(map(str, path)): value for path, member, value in component.signature.flatten(component)
            if member.flow is Out}


def described():
    """What the outputs are in each cycle in Amaranth's own simulator."""
    component, found = Cells(), []
    simulator = Simulator(component)
    simulator.add_clock(1e-8)

    async def testbench(ctx):
        # As many cycles as the reset has.
        await ctx.tick().repeat(2)
        for values in stimulus():
            for name, value in values.items():
                ctx.set(getattr(component, name), value)
            found.append({name: ctx.get(Value.cast(value).as_unsigned()) for name, value in outputs(component).items()})
            await ctx.tick()

    simulator.add_testbench(testbench)
    simulator.run()
    return found


@cocotb.test()
async def same_outputs(dut):
    """Of netlist and description, in each cycle."""
    expected = json.loads(Path(options()["expected"]).read_text())
    for name in next(stimulus()):
        getattr(dut, name).value = 0
    # The clock rises at once.
    await Timer(1, unit="ns")
    await start(dut, cycles=10_000)
    for cycle, (values, required) in enumerate(zip(stimulus(), expected, strict=True)):
        for name, value in values.items():
            getattr(dut, name).value = value
        await FallingEdge(dut.clk)
        found = {name: int(getattr(dut, name).value) for name in required}
        assert found == required, f"cycle {cycle}: {found} instead of {required}"
        await RisingEdge(dut.clk)


def run(text, expected, simulator):
    """Whether anything differs."""
    return Simulation(text, simulator).run(MODULE, ("same_outputs",), "mapped", 1, {"expected": str(expected)})


@pytest.fixture(scope="module")
def cells(tmp_path_factory):
    """The netlist's text, and where the expected outputs are."""
    folder = tmp_path_factory.mktemp("cells")
    (folder / "expected.json").write_text(json.dumps(described()))
    return mapped_text(Cells(), folder), folder / "expected.json"


@pytest.mark.parametrize("simulator", SIMULATORS[1:])
def test_the_netlist_does_what_is_described(cells, simulator):
    text, expected = cells
    kinds = set(re.findall(r"(?m)^  (DP16KD|MULT18X18D) #", text))
    assert kinds == {"DP16KD", "MULT18X18D"}
    widths = {int(width) for width in re.findall(r"DATA_WIDTH_A\(32'd(\d+)", text)}
    assert widths == {1, 2, 4, 9, 18, 36}
    assert '"OUTREG"' in text
    assert re.search(r'REG_INPUTA_CLK\("CLK0', text)
    assert re.search(r'REG_OUTPUT_CLK\("CLK0', text)
    assert not run(text, expected, simulator)


@pytest.mark.parametrize("simulator", SIMULATORS[1:])
@pytest.mark.parametrize(("there", "missing"), [
    (r'REGMODE_([AB])\("OUTREG', r'REGMODE_\1("NOREG'), (r'REG_INPUT([AB])_CLK\("CLK0', r'REG_INPUT\1_CLK("NONE'),
    (r'REG_OUTPUT_CLK\("CLK0', 'REG_OUTPUT_CLK("NONE'), ("same}} & written", "1'b1}} & written"),
    (r"(reg .* = \d+'h)f+", r"\g<1>0")], ids=["data", "operands", "product", "collision", "initial values"])
def test_what_is_missing_is_noticed(cells, simulator, there, missing):
    text, expected = cells
    changed = re.sub(there, missing, text)
    assert changed != text
    assert run(changed, expected, simulator)
