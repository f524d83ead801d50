import pytest
from amaranth.hdl import Assert, Assume, Cat, Cover, Module, Signal
from amaranth.lib import wiring

from golden.config import PRESETS
from hw.icu.ic_ray_generator import IcRayGenerator
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

# The narrowest that there is: 64 rays in 4 tiles of 4 x 4, columns and rows up to 64.
CONFIG = PRESETS["tiny"].replace({"icu.rays": 64, "icu.side_bits": 6, "icu.slots": 16, "icu.settle_bits": 4,
                                  "icu.settle_fraction": 2})
SIDE = CONFIG.icu.tile_bits
SETTLE_LATENCY = 3
ENGINE = "abc bmc3"
SECTIONS = [(7, 6, 2, 7), (0, 1, 63, 1), (47, 16, 1, 4)]


def _altered(change):
    """What the ray generator issues, but for a change."""
    def instead(dut):
        changed = change(dut.o.payload)
        return Cat(changed.get(name, dut.o.payload[name]) for name, _ in dut.o.payload.shape())
    return instead


FAULTS = {
    "a row beyond the section": {"o__payload": _altered(lambda ray: {"row": (ray.row + 1)[:len(ray.row)]})},
    "columns of another section": {"o__payload": _altered(lambda ray: {"column": (ray.column - 7)[:len(ray.column)]})},
    "another place in the memory": {"o__payload": _altered(lambda ray: {"ray": ray.ray ^ ray.slot[0]})},
}


class WindowBounds(wiring.Component):
    """Of windows within a section no ray outside the section is ever issued, and each has its own place in the memory.

    The settle map answers with any word.

    Parameters
    ----------
    dut
        The ray generator.
    section
        First column, number of columns, first row, number of rows; else any that the ray memory has room for.
    """

    def __init__(self, dut, section=None):
        self._dut, self._given = dut, section
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        add_rules(m, self.i, Assume)
        self._add_frustum(m)
        self._add_settle_map(m)
        window, section, issued = self.i.payload.window, self.section, self.o.payload
        width, height = section.end_column - section.first_column, section.end_row - section.first_row
        with m.If(self.i.valid):
            m.d.comb += [Assume(window.column_first + window.column_count <= width),
                         Assume(window.wrapped_count <= window.column_first),
                         Assume(window.row_first + window.row_count <= height)]
        column, row = issued.column - section.first_column, issued.row - section.first_row
        with m.If(self.o.valid & issued.is_ray):
            m.d.comb += [
                Assert((issued.column >= section.first_column) & (issued.column < section.end_column)),
                Assert((issued.row >= section.first_row) & (issued.row < section.end_row)),
                Assert(issued.ray[:2 * SIDE] == Cat(column[:SIDE], row[:SIDE])),
                Assert(issued.ray[2 * SIDE:] == (row >> SIDE) * self.tiles_across + (column >> SIDE)),
                Cover((column == width - 1) & (row == height - 1))]
        return m

    def _add_frustum(self, m):
        """The section; it stays."""
        section, side = self.section, 1 << SIDE
        width, height = section.end_column - section.first_column, section.end_row - section.first_row
        across, down = Signal(8), Signal(8)
        m.d.comb += [across.eq(width + side - 1 >> SIDE), down.eq(height + side - 1 >> SIDE),
                     Assume(self.tiles_across == across)]
        if self._given is not None:
            first_column, columns, first_row, rows = self._given
            m.d.comb += [Assume(section.first_column == first_column), Assume(width == columns),
                         Assume(section.first_row == first_row), Assume(height == rows)]
            return
        before, known = Signal.like(section), Signal()
        m.d.sync += [before.eq(section), known.eq(1)]
        m.d.comb += [
            Assume((section.as_value() == before.as_value()) | ~known),
            Assume(section.first_column < section.end_column), Assume(section.end_column <= 1 << CONFIG.icu.side_bits),
            Assume(section.first_row < section.end_row), Assume(section.end_row <= 1 << CONFIG.icu.side_bits),
            Assume(across * down <= CONFIG.icu.rays >> 2 * SIDE)]

    def _add_settle_map(self, m):
        valid, tag = self.o_walk.valid, self.o_walk.payload.tag
        for _ in range(SETTLE_LATENCY):
            later_valid, later_tag = Signal(), Signal.like(tag)
            m.d.sync += [later_valid.eq(valid), later_tag.eq(tag)]
            valid, tag = later_valid, later_tag
        m.d.comb += [Assume(self.i_walk.valid == valid), Assume(self.i_walk.payload.tag.as_value() == tag.as_value())]


def make():
    return IcRayGenerator(config=CONFIG)


# The first ray comes in cycle 15.
def test_no_ray_outside_any_section():
    assert prove(WindowBounds(make()), mode="bmc", depth=18, engine=ENGINE)


@pytest.mark.parametrize("section", [SECTIONS[0], *(
    pytest.param(section, marks=pytest.mark.nightly) for section in SECTIONS[1:])], ids=str)
def test_no_ray_outside_the_section(section):
    assert prove(WindowBounds(make(), section), mode="bmc", depth=24, engine=ENGINE)
    assert prove(WindowBounds(make(), section), mode="cover", depth=24)


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    control = NegativeControl(make(), FAULTS[fault])
    assert not prove(WindowBounds(control, SECTIONS[0]), mode="bmc", depth=20, engine=ENGINE)
