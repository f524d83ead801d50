"""Mutants that are proved to do what the component does."""

import cocotb
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from cocotb.triggers import FallingEdge

from golden.errors import InputError
from hw.export import verilog_of
from tb.lib.clocking import start
from tb.lib.runner import Simulation
from tb.mutation import equivalence
from tb.mutation.equivalence import is_equivalent
from tb.mutation.mutants import make_mutants

BITS, WORDS, COUNT = 4, 8, 20
HALF = 1 << BITS - 1


class Sums(wiring.Component):
    """The lower half of a sum of words; of the upper half of a register, and of a sum, nothing is observed."""

    def __init__(self):
        super().__init__({"write": In(1), "i": In(BITS), "o": Out(BITS - 1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.words = words = Memory(shape=BITS, depth=WORDS, init=[])
        port, look = words.write_port(), words.read_port()
        held = Signal(2 * BITS)
        m.d.comb += [port.en.eq(self.write), port.addr.eq(self.i), port.data.eq(self.i + 1), look.addr.eq(self.i)]
        m.d.sync += [held.eq(look.data + (self.i << BITS)), self.o.eq(held + self.i)]
        return m


@cocotb.test()
async def sums(dut):
    """Against a model, for as long as nothing of it is missed."""
    dut.write.value = 0
    await start(dut, cycles=5_000)
    await FallingEdge(dut.clk)
    words, look, held, o = [0] * WORDS, 0, 0, 0
    for cycle in range(2_000):
        i, write = (cycle * 7 + cycle // 16) % (1 << BITS), cycle % 3 != 1
        dut.i.value, dut.write.value = i, write
        await FallingEdge(dut.clk)
        o, held, look = (held + i) % HALF, look, words[i % WORDS]
        if write:
            words[i % WORDS] = (i + 1) % (1 << BITS)
        if cycle > 3:
            assert int(dut.o.value) == o, cycle


@pytest.fixture(scope="module")
def mutants():
    return make_mutants(verilog_of(Sums(), "top"), count=COUNT, seed=1)


@pytest.mark.sim
def test_a_mutant_that_is_found_is_not_proved(mutants):
    simulation = Simulation(mutants.text)

    def is_found(mutant):
        return bool(simulation.run("tb.mutation.test_equivalence", ("sums",), f"mutants/sums-{mutant}", 1, {},
                                   plusargs=(f"+mutant={mutant}",), failures=1))

    assert not is_found(0)
    found = [mutant for mutant in range(1, COUNT + 1) if is_found(mutant)]
    proved = [mutant for mutant in range(1, COUNT + 1) if is_equivalent(mutants, mutant)]
    assert len(found) > COUNT // 3
    # Halves that are not observed.
    assert len(proved) > COUNT // 10
    assert not set(found) & set(proved)


def test_no_mutant_is_the_component_itself(mutants):
    assert is_equivalent(mutants, 0)


@pytest.mark.parametrize(("line", "proved"), [
    ("ERROR: Called with -verify and proof did fail!", False),
    ("ERROR: Called with -verify and proof did time out!", False),
    ("ERROR: No such command: sat", None)])
def test_only_the_proof_itself_may_fail(mutants, monkeypatch, line, proved):
    def yosys(log, *commands):
        log.write_text(f"-- Running command --\n{line}\n")
        raise InputError(line)

    monkeypatch.setattr(equivalence, "yosys", yosys)
    if proved is None:
        with pytest.raises(InputError, match="No such command"):
            is_equivalent(mutants, 1)
    else:
        assert is_equivalent(mutants, 1) is proved


def test_of_large_memories_nothing_is_proved(mutants, monkeypatch):
    monkeypatch.setattr(equivalence, "MOST_BITS", BITS * WORDS - 1)
    assert not is_equivalent(mutants, 0)
