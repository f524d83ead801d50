"""Verilog of a component: what memories begin with survives being written as loops."""

import cocotb
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles

from hw.export import verilog_of
from tb.lib.clocking import start
from tb.lib.runner import SIMULATORS, simulate

WORDS = [0] * 20 + [5, 6, 7] + [9] * 12 + [0] * 3 + [1] * 8 + [2] * 9


class Rom(wiring.Component):
    """`WORDS`, and a member of no bits."""

    def __init__(self):
        super().__init__({"address": In(range(len(WORDS))), "data": Out(8), "nothing": In(0)})

    def elaborate(self, platform):
        m = Module()
        m.submodules["words.all"] = memory = Memory(shape=8, depth=len(WORDS), init=WORDS)
        port = memory.read_port()
        m.d.comb += [port.addr.eq(self.address), self.data.eq(port.data)]
        return m


class Zeros(wiring.Component):
    """Two memories that begin with zeros, words of 70 bits and of one."""

    def __init__(self):
        super().__init__({"write": In(1), "address": In(range(len(WORDS))), "wide": Out(70), "narrow": Out(1)})

    def elaborate(self, platform):
        m = Module()
        for name, output in ("wide.words", self.wide), ("bits", self.narrow):
            m.submodules[name] = memory = Memory(shape=len(output), depth=len(WORDS), init=[])
            port, look = memory.write_port(), memory.read_port()
            m.d.comb += [port.en.eq(self.write), port.addr.eq(self.address), port.data.eq(-1),
                         look.addr.eq(self.address), output.eq(look.data)]
        return m


def test_runs_of_words_are_loops():
    text = verilog_of(Rom(), "rom")
    assert [line.split("(")[1] for line in text.splitlines() if "for (" in line] == [
        rf"k = {first}; k <= {last}; k = k + 1) \words.all [k] = 8'h0{word};"
        for first, last, word in ((0, 19, 0), (23, 34, 9), (46, 54, 2))]
    assert "[-1:0]" not in text
    assert "nothing" not in text


def test_zeros_are_loops():
    text = verilog_of(Zeros(), "zeros")
    assert sorted(line.strip() for line in text.splitlines() if "for (" in line) == [
        f"for (k = 0; k <= {len(WORDS) - 1}; k = k + 1) {memory} [k] = {bits}'h0;"
        for memory, bits in ((r"\wide.words", 70), ("bits", 1))]


@cocotb.test()
async def every_word(dut):
    await start(dut, cycles=200)
    for address, word in enumerate(WORDS):
        dut.address.value = address
        await ClockCycles(dut.clk, 2)
        assert int(dut.data.value) == word, address


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_words(simulator):
    simulate(Rom(), "tb.package.test_export", ("every_word",), simulator=simulator, name=f"export-{simulator}")


@cocotb.test()
async def zeros_until_written(dut):
    dut.write.value = 0
    await start(dut, cycles=1_000)
    for value in 0, 1:
        for address in range(len(WORDS)):
            dut.write.value, dut.address.value = value, address
            await ClockCycles(dut.clk, 2 + value)
            assert (int(dut.wide.value), int(dut.narrow.value)) == (value * ((1 << 70) - 1), value), address


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_zeros(simulator):
    simulate(Zeros(), "tb.package.test_export", ("zeros_until_written",), simulator=simulator,
             name=f"zeros-{simulator}")
