"""A component that uses what it reads of a word while it is written gives other results; any other gives the same."""

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from tb.lib.collisions import with_collisions


class Words(wiring.Component):
    """Writes a byte and reads one; a cycle later the byte that was there."""

    def __init__(self, *, domain, attrs, granularity=None):
        super().__init__({"write": In(3), "read": In(3), "enable": In(2), "data": In(8), "o": Out(8)})
        self._domain, self._attrs, self._granularity = domain, attrs, granularity

    def elaborate(self, platform):
        """A memory of eight bytes."""
        m = Module()
        m.submodules.memory = memory = Memory(shape=8, depth=8, init=range(1, 9), attrs=self._attrs)
        write = memory.write_port(granularity=self._granularity)
        read = memory.read_port(domain=self._domain)
        m.d.comb += [write.addr.eq(self.write), write.data.eq(self.data), write.en.eq(self.enable),
                     read.addr.eq(self.read)]
        if self._domain == "comb":
            m.d.sync += self.o.eq(read.data)
        else:
            m.d.comb += self.o.eq(read.data)
        return m


def read_beside_write(words, *, write, enable):
    """The byte of address 3, 4, that is read while an address is written."""
    found = []

    async def bench(ctx):
        for port, value in (("write", write), ("enable", enable), ("read", 3), ("data", 0x77)):
            ctx.set(getattr(words, port), value)
        await ctx.tick()
        found.append(ctx.get(words.o))

    simulator = Simulator(with_collisions(words))
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return found[0]


@pytest.mark.parametrize("domain", ["comb", "sync"])
@pytest.mark.parametrize(("granularity", "write", "enable", "expected"), [
    (None, 3, 1, 4 ^ 0xFF), (None, 2, 1, 4), (None, 3, 0, 4), (4, 3, 1, 4 ^ 0x0F), (4, 3, 2, 4 ^ 0xF0), (4, 2, 3, 4)])
def test_the_bits_that_are_written_are_read_inverted(domain, granularity, write, enable, expected):
    words = Words(domain=domain, attrs={"no_rw_check": 1}, granularity=granularity)
    assert read_beside_write(words, write=write, enable=enable) == expected


@pytest.mark.parametrize("domain", ["comb", "sync"])
def test_a_memory_that_promises_the_old_word_gives_it(domain):
    assert read_beside_write(Words(domain=domain, attrs={}), write=3, enable=1) == 4
