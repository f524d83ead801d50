"""Verilog of a component: initial values of memories survive being written as loops."""

import gc
import re

import cocotb
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles

from radiosity.flow.verilog import zero_memories
from radiosity.flow.verilog.export import verilog_of
from radiosity.flow.verilog.verilog_text import add_zero_loops, merge_equal_words, wait_for_nothing, without_ram_styles
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


def test_this_version_of_amaranth_is_supported():
    assert zero_memories.is_supported()


@pytest.mark.parametrize("component", [Rom, Zeros])
def test_the_text_is_the_same_without_the_replacement(component, monkeypatch):
    text = verilog_of(component(), "top")
    monkeypatch.setattr(zero_memories, "TESTED", "0.6.")
    assert not zero_memories.is_supported()

    def without_labels(text):
        """Loops of zeros and of other words have labels and forms of their own."""
        return sorted(re.findall(r"k = \d+; k <= \d+; k = k \+ 1\) \S+ ?\[k\] = \S+;",
                                 re.sub(r"'h0+;", "'h0;", text.replace(" [k]", "[k]"))))

    assert without_labels(verilog_of(component(), "top")) == without_labels(text)


def test_a_converter_with_another_method_is_not_replaced(monkeypatch):
    def emit_memory(emitter, memory):
        raise AssertionError

    monkeypatch.setattr(zero_memories.rtlil.ModuleEmitter, "emit_memory", emit_memory)
    with zero_memories.omit_zeros() as omitted:
        assert zero_memories.rtlil.ModuleEmitter.emit_memory is emit_memory
    assert not omitted


def test_no_memory_is_forgotten():
    with pytest.raises(RuntimeError, match=r"^2 memories must be without initial values, not 1$"):
        add_zero_loops("  reg [3:0] words [7:0];\n", 2)


def test_a_combinational_block_has_a_known_form():
    with pytest.raises(RuntimeError, match=r"^Yosys must write combinational blocks in the form that is known"):
        wait_for_nothing("module top(o);\n  always @* o = 1'h0;\nendmodule\n")


def written_words(lines):
    """The words that loops write, by running the loops."""
    text = "".join(lines).replace("\n", " ")
    outer = r"for \(j = 0; j < (?P<rows>\d+); j = j \+ 1\)\s+"
    inner = r"for \(k = (?P<first>\d+); k <= (?P<last>\d+); k = k \+ 1\) words\s*\[(?:(?P<step>\d+) \* j \+ )?k\]"
    for found in re.finditer(f"(?:{outer})?{inner}", text):
        first, last = int(found["first"]), int(found["last"])
        rows = range(int(found["rows"] or 1))
        assert max(len(rows), last + 1 - first) <= 5000, "Quartus refuses longer loops"
        yield from (int(found["step"] or 0) * row + word for row in rows for word in range(first, last + 1))


@pytest.mark.parametrize("depth", [1, 1023, 1024, 1025, 4096, 10_000, 1 << 20])
def test_no_loop_is_longer_than_tools_accept(depth):
    """Loops that are as long as a memory write each word once."""
    zeros = add_zero_loops(f"  reg [3:0] words [{depth - 1}:0];\n", 1)
    assert [*written_words([zeros])] == [*range(depth)]
    if 8 < depth <= 10_000:
        equal = merge_equal_words("".join(f"    words[{word + 3}] = 4'h7;\n" for word in range(depth)))
        assert [*written_words([equal])] == [*range(3, depth + 3)]


def test_kinds_of_memories_are_left_to_the_tools():
    kept = "  (* no_rw_check = 32'd1 *)\n  reg [3:0] words [7:0];\n"
    assert without_ram_styles(f"  (* ram_style = \"distributed\" *)\n{kept}") == kept


@cocotb.test()
async def every_word(dut):
    await start(dut, cycles=200)
    for address, word in enumerate(WORDS):
        dut.address.value = address
        await ClockCycles(dut.clk, 2)
        assert int(dut.data.value) == word, address


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_words(simulator):
    simulate(Rom(), "tb.radiosity.flow.package.test_export", ("every_word",), simulator=simulator,
             name=f"export-{simulator}")


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
    simulate(Zeros(), "tb.radiosity.flow.package.test_export", ("zeros_until_written",), simulator=simulator,
             name=f"zeros-{simulator}")


def test_no_garbage_is_collected_during_an_export():
    enabled = []

    class Watched(Rom):
        def elaborate(self, platform):
            enabled.append(gc.isenabled())
            return super().elaborate(platform)

    verilog_of(Watched(), "top")
    assert enabled
    assert not any(enabled)
    assert gc.isenabled()
