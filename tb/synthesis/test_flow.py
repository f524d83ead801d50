"""Area: what a component takes, block RAMs above all."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.shared_port import write_in_place_of
from hw.synthesis.flow import synthesise

DEPTH, WIDTH = 1024, 18


class TwoReaders(wiring.Component):
    """One block RAM's worth of words with two readers; who fills it takes the place of one of them."""

    def __init__(self):
        super().__init__({"enable": In(1), "address": In(range(DEPTH)), "data": In(WIDTH),
                          "asked": In(range(DEPTH)).array(2), "found": Out(WIDTH).array(2)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=WIDTH, depth=DEPTH, init=[], attrs={"no_rw_check": 1})
        reads = [memory.read_port() for _ in range(2)]
        for asked, found, read in zip(self.asked, self.found, reads, strict=True):
            m.d.comb += [read.addr.eq(asked), found.eq(read.data)]
        write_in_place_of(reads[1], m, memory.write_port(), enable=self.enable, address=self.address, data=self.data)
        return m


def test_a_block_ram_serves_two_readers_and_who_fills_it(tmp_path):
    area = synthesise(TwoReaders(), tmp_path)
    # The choice of the address is all there is beside it.
    assert (area.bram, area.ff, area.dsp) == (1, 0, 0)
    assert area.lut <= DEPTH.bit_length()
