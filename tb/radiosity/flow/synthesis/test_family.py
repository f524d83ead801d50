"""Area in cells of each family: each cell is counted or known to be free; memories that no RAM supports are named."""

import pytest
from amaranth.hdl import Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.base.errors import InputError
from radiosity.flow.synthesis.family import FAMILIES, Area
from radiosity.flow.synthesis.flow import synthesise

DEPTH, WIDTH, OPERAND = 256, 16, 16


class Parts(wiring.Component):
    """A product, a memory with so many writers, and a sum."""

    def __init__(self, writers=1):
        self._writers = writers
        super().__init__({"a": In(signed(OPERAND)), "b": In(signed(OPERAND)), "write": In(1), "to": In(range(DEPTH)),
                          "at": In(range(DEPTH)), "product": Out(signed(2 * OPERAND)), "word": Out(WIDTH),
                          "sum": Out(8)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=WIDTH, depth=DEPTH, init=[], attrs={"no_rw_check": 1})
        read = memory.read_port()
        for number in range(self._writers):
            port = memory.write_port()
            m.d.comb += [port.en.eq(self.write), port.addr.eq(self.to + number), port.data.eq(self.a)]
        a, b = Signal(signed(OPERAND), reset_less=True), Signal(signed(OPERAND), reset_less=True)
        m.d.sync += [a.eq(self.a), b.eq(self.b), self.sum.eq(self.sum + self.b[:8])]
        m.d.comb += [read.addr.eq(self.at), self.word.eq(read.data), self.product.eq(a * b)]
        return m


def test_cells_are_counted_in_units():
    ecp5, xc7, gowin, ice40 = (FAMILIES[name] for name in ("ecp5", "xc7", "gowin", "ice40"))
    assert ecp5.area({"LUT4": 3, "CCU2C": 5, "TRELLIS_DPR16X4": 2, "TRELLIS_FF": 7, "MULT18X18D": 1, "DP16KD": 4,
                      "PFUMX": 9}) == Area(lut=3 + 10 + 12, ff=7, dsp=1, bram=4)
    assert xc7.area({"LUT6": 2, "RAM32M": 3, "SRL16E": 1, "FDRE": 5, "FDSE": 2, "RAMB18E1": 1, "RAMB36E1": 2,
                     "CARRY4": 8}) == Area(lut=2 + 12 + 1, ff=7, dsp=0, bram=5)
    assert gowin.area({"LUT4": 1, "ALU": 4, "RAM16SDP4": 1, "DFFSE": 2, "MULT9X9": 1, "MULT36X36": 1,
                       "SDPX9B": 3}) == Area(lut=1 + 4 + 6, ff=2, dsp=5, bram=3)
    assert ice40.area({"SB_LUT4": 4, "SB_CARRY": 3, "SB_DFFESR": 6, "SB_MAC16": 2, "SB_RAM40_4K": 1}) == Area(
        lut=4, ff=6, dsp=2, bram=1)


@pytest.mark.parametrize("family", FAMILIES)
def test_an_unknown_cell_is_an_error(family):
    with pytest.raises(InputError, match=r"Cells for .* must be of a type that is counted, not NEW"):
        FAMILIES[family].area({"NEW": 1})


@pytest.mark.parametrize("family", [name if name == "gowin" else pytest.param(name, marks=pytest.mark.nightly)
                                    for name in FAMILIES])
def test_parts_are_where_they_belong(family, tmp_path):
    area = synthesise(Parts(), tmp_path, family=FAMILIES[family])
    # Eight registers have the sum; those of the operands may be inside the multiplier.
    assert (area.dsp, area.bram) == (1, 1)
    assert area.ff == 8 + (2 * OPERAND if family == "gowin" else 0)
    assert 8 <= area.lut <= 20


@pytest.mark.parametrize("family", ["ice40", pytest.param("xc7", marks=pytest.mark.nightly),
                                    pytest.param("gowin", marks=pytest.mark.nightly)])
def test_a_memory_without_a_home_is_named(family, tmp_path):
    with pytest.raises(InputError, match=rf"report: {FAMILIES[family].title} has no RAM with the ports of memory"):
        synthesise(Parts(writers=3), tmp_path, family=FAMILIES[family])
