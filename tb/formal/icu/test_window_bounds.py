from amaranth.hdl import Assert, Assume, Cat, Cover, Signal

from golden.engine.config import PRESETS
from hw.icu.ic_ray_generator import IcRayGenerator
from tb.formal.bench import Bench
from tb.formal.declare import Claim, Control, declare
from tb.formal.stream_rules import add_rules

# The narrowest that there is: 64 rays in 4 tiles of 4 x 4, columns and rows up to 64.
CONFIG = PRESETS["tiny"].replace({"icu.rays": 64, "icu.side_bits": 6, "icu.slots": 16, "icu.settle_bits": 4,
                                  "icu.settle_fraction": 2})
SIDE = CONFIG.icu.tile_bits
SETTLE_LATENCY = 3
SECTIONS = [(7, 6, 2, 7), (0, 1, 63, 1), (47, 16, 1, 4)]


def _altered(change):
    """What the ray generator issues, but for a change."""
    def instead(dut):
        changed = change(dut.o.payload)
        return Cat(changed.get(name, dut.o.payload[name]) for name, _ in dut.o.payload.shape())
    return instead


def within_the_section(m, bench, dut, given=None):
    """Of windows within a section no ray outside the section is ever issued, and each has its own memory address.

    ``given``: first column, number of columns, first row, number of rows; else any that the ray memory can hold.
    The settle map answers with any word.
    """
    add_rules(m, dut.i, Assume)
    _add_section(m, dut, given)
    _add_settle_map(m, dut)
    window, section, issued = dut.i.payload.window, dut.section, dut.o.payload
    width, height = section.end_column - section.first_column, section.end_row - section.first_row
    # A claim of the ray generator, which machines with checks have too.
    with m.If(dut.i.valid & window.row_count.any() & window.column_count.any()):
        m.d.comb += [Assume(window.column_first + window.column_count <= width),
                     Assume(window.wrapped_count <= window.column_first),
                     Assume(window.row_first + window.row_count <= height)]
    column, row = issued.column - section.first_column, issued.row - section.first_row
    with m.If(dut.o.valid & issued.is_ray):
        m.d.comb += [
            Assert((issued.column >= section.first_column) & (issued.column < section.end_column), "columns"),
            Assert((issued.row >= section.first_row) & (issued.row < section.end_row), "rows"),
            Assert(issued.ray[:2 * SIDE] == Cat(column[:SIDE], row[:SIDE]), "address"),
            Assert(issued.ray[2 * SIDE:] == (row >> SIDE) * dut.tiles_across + (column >> SIDE), "address"),
            Cover((column == width - 1) & (row == height - 1), "the last ray")]


def _add_section(m, dut, given):
    """The section; it stays."""
    section, side = dut.section, 1 << SIDE
    width, height = section.end_column - section.first_column, section.end_row - section.first_row
    across, down = Signal(8), Signal(8)
    m.d.comb += [across.eq(width + side - 1 >> SIDE), down.eq(height + side - 1 >> SIDE),
                 Assume(dut.tiles_across == across)]
    if given is not None:
        first_column, columns, first_row, rows = given
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


def _add_settle_map(m, dut):
    valid, tag = dut.o_walk.valid, dut.o_walk.payload.tag
    for _ in range(SETTLE_LATENCY):
        later_valid, later_tag = Signal(), Signal.like(tag)
        m.d.sync += [later_valid.eq(valid), later_tag.eq(tag)]
        valid, tag = later_valid, later_tag
    m.d.comb += [Assume(dut.i_walk.valid == valid), Assume(dut.i_walk.payload.tag.as_value() == tag.as_value())]


# The first ray comes in cycle 15.
test_window_bounds = declare(
    lambda section=SECTIONS[0]: Bench(within_the_section, IcRayGenerator(config=CONFIG), given=section),
    cycles=24, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(section=None, cycles=18), Claim(section=SECTIONS[0]),
            *(Claim(section=section, nightly=True) for section in SECTIONS[1:])],
    controls={
        "a row beyond the section": Control(
            "rows", {"o__payload": _altered(lambda ray: {"row": (ray.row + 1)[:len(ray.row)]})}),
        "columns of another section": Control(
            "columns", {"o__payload": _altered(lambda ray: {"column": (ray.column - 7)[:len(ray.column)]})}),
        "another address in the memory": Control(
            "address", {"o__payload": _altered(lambda ray: {"ray": ray.ray ^ ray.slot[0]})}),
    })
