"""The filter: of any one number the first in each generation passes, and no other, in any traffic of others."""

import pytest
from amaranth.hdl import Assert, Assume, Const, Cover, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hw.lib.generations import Generations
from hw.lib.update_memory import UpdateMemory
from hw.memsys import filter as module
from hw.memsys.filter import Filter
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

BITS, COUNT, WORD = 3, 4, 2


class OncePerGeneration(wiring.Component):
    """Follows one number, ``place``. What comes goes in its order, so it is enough to count.

    Parameters
    ----------
    eager
        Only 0 comes, and nothing waits for the output: enough to reach what is covered, in a fraction of the time.
    """

    def __init__(self, dut, *, eager=False):
        self._dut, self._eager = dut, eager
        super().__init__({**dict(dut.signature.members.items()), "place": In(BITS)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        for given in (self.i_start, self.i):
            add_rules(m, given, Assume)
        add_rules(m, self.o, Assert)
        place, limit, begun = Signal(BITS), Signal.like(dut.limit), Signal()
        m.d.sync += [begun.eq(1), place.eq(self.place), limit.eq(self.limit)]
        with m.If(begun):
            m.d.comb += [Assume(self.place == place), Assume(self.limit == limit)]
        m.d.comb += Assume(self.limit <= COUNT)
        if self._eager:
            m.d.comb += [Assume(self.place == 0), Assume(self.i.payload == 0), Assume(self.limit == COUNT),
                         Assume(self.o.ready)]

        taken, passes = dut.i.valid & dut.i.ready, dut.o.valid & dut.o.ready
        starts = dut.i_start.valid & dut.i_start.ready
        # Of the number followed: those that have been taken and have left, and whether one has passed.
        mine, mine_left, inside, passed, waits = Signal(5), Signal(5), Signal(5), Signal(), Signal()
        comes = taken & (dut.i.payload == self.place)
        goes = passes & (dut.o.payload == self.place)
        drops = dut.dropped & (dut.number == self.place)
        there = self.place < self.limit
        m.d.sync += [inside.eq(inside + taken - passes - dut.dropped), mine.eq(mine + comes - goes - drops),
                     mine_left.eq(mine_left + goes + drops), passed.eq(passed | goes), waits.eq(dut.i_start.valid)]
        with m.If(starts):
            m.d.sync += passed.eq(0)
            m.d.comb += [Assert(inside == 0), Assert(~taken)]
        m.d.comb += [Assert(~(passes & dut.dropped)), Assert(inside <= Filter.capacity)]
        with m.If(passes | dut.dropped):
            m.d.comb += Assert(inside != 0)
        with m.If(goes | drops):
            m.d.comb += Assert(mine != 0)
        with m.If(goes):
            m.d.comb += [Assert(~passed), Assert(there)]
        with m.If(drops):
            m.d.comb += [Assert(passed | ~there), Assert(dut.wrong == ~there)]
        m.d.comb += Cover(goes & (mine_left >= 2))
        return m


def make(**given):
    return OncePerGeneration(Filter(bits=BITS, count=COUNT, generation_bits=1, word_bits=WORD), **given)


def check(bench, depth=18):
    return prove(bench, mode="bmc", depth=depth, engine="abc bmc3")


def test_each_number_passes_once():
    assert check(make(), 13)


# Each further cycle takes twice as long as the one before.
@pytest.mark.nightly
def test_each_number_passes_once_for_longer():
    assert check(make(), 20)


@pytest.mark.nightly
def test_reaches_a_second_generation():
    assert prove(make(eager=True), mode="cover", depth=30)


class Blind(UpdateMemory):
    """Does not look at the number just in front."""

    def _same_as(self, m, addresses, ahead, *, age):
        return Const(0) if ahead == 1 else super()._same_as(m, addresses, ahead, age=age)


def test_one_that_does_not_see_the_number_in_front(monkeypatch):
    monkeypatch.setattr(module, "UpdateMemory", Blind)
    assert not check(make(), 14)


class Sweepless(Generations):
    """Begins again without having emptied the memory."""

    def elaborate(self, platform):
        m = Module()
        m.d.comb += [self.i_start.ready.eq(1), self.generation.eq(1)]
        return m


@pytest.mark.nightly
def test_one_that_empties_nothing(monkeypatch):
    monkeypatch.setattr(module, "Generations", Sweepless)
    assert not check(make())


@pytest.mark.nightly
def test_one_that_lets_pass_what_there_is_not():
    control = NegativeControl(Filter(bits=BITS, count=COUNT, generation_bits=1, word_bits=WORD),
                {"dropped": lambda dut: dut.dropped & ~dut.wrong})
    assert not check(OncePerGeneration(control), 14)
