# amaranth: UnusedElaboratable=no

import numpy as np
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.position_search import PositionSearch
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
ENTRIES, SEARCHES = 120, 80
SPREAD = 900
# Of the bounds.
HIGHEST = (1 << CtuFormats(CONFIG).position_bound.width - 1) - 1


def searches(random, positions):
    """Parts of the table and bounds: random ones, one entry, all of it; on positions, and beyond all of them."""
    for number in range(SEARCHES):
        first = int(random.integers(ENTRIES))
        count = 1 if number % 7 == 3 else int(random.integers(1, ENTRIES - first, endpoint=True))
        if number % 7 == 5:
            first, count = 0, ENTRIES
        low, end = (int(value) for value in random.integers(-2 * SPREAD, 2 * SPREAD, 2))
        if number % 3 == 1:
            low, end = int(positions[first]), int(positions[first + count - 1]) + number % 2
        yield {"first": first, "count": count, "low": low, "end": end}


def test_counts_of_what_is_less():
    formats, random = CtuFormats(CONFIG), np.random.default_rng(1)
    search = PositionSearch(formats=formats, address=formats.grid_row_address)
    positions = np.sort(random.integers(-SPREAD, SPREAD, ENTRIES))
    positions[ENTRIES // 2:ENTRIES // 2 + 9] = positions[ENTRIES // 2]
    done = []

    async def drive(ctx):
        for address, position in enumerate(positions.tolist()):
            ctx.set(search.i_write.payload, {"address": address, "position": position})
            ctx.set(search.i_write.valid, 1)
            await ctx.tick()
        ctx.set(search.i_write.valid, 0)
        for number, given in enumerate(searches(random, positions)):
            ctx.set(search.i.payload, given)
            ctx.set(search.i.valid, 1)
            await ctx.tick().until(search.i.ready)
            ctx.set(search.i.valid, 0)
            cycles = 1
            while not ctx.get(search.o.valid):
                await ctx.tick()
                cycles += 1
            # What has been found stays until it is taken.
            await ctx.tick().repeat(1 + number % 4)
            part = positions[given["first"]:given["first"] + given["count"]]
            assert ctx.get(search.o.valid)
            for name in "low", "end":
                found = ctx.get(search.o.payload[name])
                assert found["count"] == (part < given[name]).sum(), given
                # The least and the most bound with as many below.
                places = np.concatenate([[-HIGHEST - 2], part, [HIGHEST]])
                assert found["least"] == places[found["count"]] + 1, given
                assert found["most"] == places[found["count"] + 1], given
            assert cycles == documented_latency(PositionSearch, CONFIG, count=given["count"])
            ctx.set(search.o.ready, 1)
            await ctx.tick()
            ctx.set(search.o.ready, 0)
            done.append(given)

    simulator = Simulator(search)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.run()
    assert len(done) == SEARCHES
