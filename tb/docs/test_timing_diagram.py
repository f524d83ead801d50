import pytest

from hw.lib.skid_buffer import SkidBuffer
from tb.docs.timing_diagram import Lane, draw_lanes, give, record, stream_lanes
from tb.docs.waveforms import WAVEFORMS

DUT = SkidBuffer(8)
LANES = [*stream_lanes("i", DUT.i, str), *stream_lanes("o", DUT.o, str), Lane("bit", DUT.o.valid)]


async def drive(ctx):
    ctx.set(DUT.o.ready, 1)
    await give(ctx, DUT.i, [None, 3, 4, None, 5])


@pytest.fixture(scope="module")
def rows():
    return record(DUT, LANES, drive, cycles=8)


def test_what_is_recorded_is_what_goes_in_and_out(rows):
    given = [value for value, means in rows[2] if means]
    assert given == [value for value, means in rows[5] if means] == [3, 4, 5]
    assert [means for _, means in rows[2]] == [0, 1, 1, 0, 1, 0, 0, 0]
    assert rows[6] == [(valid, valid) for valid, _ in rows[3]]


def test_all_rows_and_values_are_drawn(rows):
    text = draw_lanes(LANES, rows, ranges=[range(2), range(4, 8)])
    for name in ("cycle", "i.valid", "i.ready", "i.payload", "o.payload", "bit", "3", "5"):
        assert f">{name}<" in text
    assert text == draw_lanes(LANES, rows, ranges=[range(2), range(4, 8)])


@pytest.mark.parametrize("page", ["network.md", "engine.md", "memory-path.md"])
def test_waveforms_of_pages(page):
    text = WAVEFORMS[page].draw()
    assert text.startswith("<svg")
    assert "cycle" in text
