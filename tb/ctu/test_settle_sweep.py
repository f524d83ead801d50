"""Sweeps of the settle map from frustum to frustum; `tb.ctu.test_survival` has what they decide."""

from itertools import product

import pytest

from hw.ctu.settle_sweep import SettleSweep
from hw.ctu.square_scan import SIDE_BITS
from tb.lib.configurations import config_of
from tb.lib.simulator import simulator_of

# Tiles of the section.
ACROSS, DOWN = 6, 5


def squares(level):
    """Those of a level that hold a tile of the section."""
    return set(product(*(range(-(-count >> SIDE_BITS * level)) for count in (ACROSS, DOWN))))


@pytest.mark.parametrize("levels", [1, 2])
def test_a_frustum_is_fresh_when_all_of_its_squares_have_been_read(levels):
    """Wherever the sweep of the one before has ended."""
    config = config_of({"ctu.pyramid_levels": levels})
    dut, side = SettleSweep(config=config), 1 << config.icu.tile_bits
    outputs = [getattr(dut, f"o_{level}") for level in range(levels)]
    signals = [dut.o_tile.valid & dut.o_tile.ready, dut.i_word.valid & dut.i_word.ready, dut.i_start.ready, dut.fresh,
               *(signal for one in outputs for signal in (one.valid, one.payload))]

    async def testbench(ctx):
        ctx.set(dut.section, {"first_column": 0, "end_column": ACROSS * side, "first_row": 0, "end_row": DOWN * side})
        await ctx.tick().repeat(3)
        cycle, waiting, left = 0, [], 0
        for frustum, later in enumerate(range(1, 60, 6), start=1):
            seen, starts, left = [{} for _ in outputs], True, later
            while left:
                ctx.set(dut.i_start.valid, int(starts))
                ctx.set(dut.o_tile.ready, int(len(waiting) < 8))
                ctx.set(dut.i_word.valid, int(bool(waiting) and waiting[0] <= cycle))
                ctx.set(dut.i_word.payload, [frustum] * side**2)
                requests, given, ready, fresh, *found = (await ctx.tick().sample(*signals))[2:]
                cycle, left = cycle + 1, left - (fresh and not starts)
                waiting = waiting[given:] + [cycle + 3] * requests
                if starts:
                    starts = not ready
                    continue
                for codes, valid, made in zip(seen, found[::2], found[1::2], strict=True):
                    if valid:
                        codes[made.column, made.row] = made.code
                if fresh:
                    assert [set(codes) for codes in seen] == [squares(level) for level in range(levels)]
            assert all(set(codes.values()) == {frustum} for codes in seen)

    simulator_of(dut, testbench).run()
