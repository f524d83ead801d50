from hypothesis import given
from hypothesis import strategies as st

from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import HitFormat
from hw.memsys.results.result_address import ResultAddress
from tb.lib.configurations import config_of
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.lib.timing import documented_latency
from tb.memsys.section_results import drawn_section

CONFIGS = {bits: config_of({"memory.data_bits": bits}) for bits in (64, 128, 256, 512)}
BENCHES = {bits: ScheduleBench(ResultAddress(config=config), idle_limit=40) for bits, config in CONFIGS.items()}


def expected(section, bits):
    command, rays = section.command, section.command.section
    size = max(1, command.hit_format.bytes)
    written = min(size, bits // 8)
    skipped = command.columns - (rays.end_column - rays.first_column)
    return {"hits": command.hits + size * (rays.first_row * command.columns + rays.first_column),
            "sums": int(command.sums), "sums_address": command.sums_address, "hit_format": int(command.hit_format),
            "last_column": rays.end_column - 1, "single": int(rays.end_column - rays.first_column == 1),
            "jump": (skipped * size + written) // 4}


@SETTINGS
@given(st.sampled_from(sorted(CONFIGS)), st.lists(st.tuples(st.integers(0, 1 << 20), st.integers(0, 9)), max_size=4),
       st.lists(st.integers(0, 20), max_size=4))
def test_extents(bits, drawn, stalls):
    """The address of the first hit, and the lanes to the next row."""
    formats = [HitFormat.FULL, HitFormat.COMPACT, HitFormat.IDS]
    sections = [drawn_section(seed, CONFIGS[bits], side=1 << 10, base=4096, hit_format=formats[seed % 3])
                for seed, _ in drawn]
    came = BENCHES[bits].run(Schedule(items={"i": [(idle, one.command_item) for one, (_, idle) in zip(
        sections, drawn, strict=True)]}, stalls={"o": stalls}))
    assert came["o"] == [expected(one, bits) for one in sections]


def test_widest_frustum():
    """The last rays of the largest frustum."""
    side = 1 << CONFIGS[64].icu.side_bits
    section = drawn_section(1, CONFIGS[64], columns=side, section=Sector(side - 1, side, side - 1, side),
                            hit_format=HitFormat.FULL, base=1 << 30)
    came = BENCHES[64].run(Schedule(items={"i": [(0, section.command_item)]}))
    assert came["o"] == [expected(section, 64)]


def test_latency():
    """A command that waits is accepted in the cycle before its result is offered."""
    rows = (0, 1, 9, 0)
    sections = [drawn_section(k, CONFIGS[64], columns=8, section=Sector(0, 8, row, row + 1), hit_format=HitFormat.FULL)
                for k, row in enumerate(rows)]
    bench = BENCHES[64]
    bench.run(Schedule(items={"i": [(0, one.command_item) for one in sections]}))
    accepted, left, offered = bench.cycles["i"], bench.cycles["o"], 1
    for row, taken, came in zip(rows, accepted, left, strict=True):
        assert came - offered == documented_latency(ResultAddress, CONFIGS[64], first_row=row)
        assert came - taken == 1
        offered = taken + 1
