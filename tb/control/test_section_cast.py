"""Sections one after the other in units that take their time: none starts early, none is lost, few cycles between."""

import random

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.control.section_cast import SectionCast
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
UNITS = ("memory", "intersection", "traversal", "near")
# Cycles without an event after which a run has failed.
LIMIT = 500


class _Cluster:
    """The units of a cluster as far as `SectionCast` sees them; ``slow`` is the longest time of each step.

    Patches enter while cells are in flight, and are done later. Read-outs take their time, and two banks of the ray
    memory allow one cast beside one read-out.
    """

    def __init__(self, sections, seed, slow):
        self.draw, self.slow, self.sections = random.Random(seed), slow, list(sections)
        self.cycle = self.event = 0
        self.log, self.taken, self.tiles, self.requests, self.reading, self.early = [], 0, [], [], 0, 0

    def pause(self):
        return self.draw.randrange(self.slow + 1)

    def note(self, what):
        self.log.append((self.cycle, what))
        self.event = self.cycle


def run(sections, *, seed=1, slow=6, late=0, read_out=5):
    """The log of all events, and the cycles that were counted for each section; a read-out takes ``read_out`` steps."""
    dut, it = SectionCast(config=CONFIG), _Cluster(sections, seed, slow)
    counted, settings = [], {"columns": 0}

    async def units(ctx):
        starts = dict.fromkeys(UNITS, None)
        begun, cells, done_at, next_at = 0, 0, [], late
        final, closed, last, offered = False, False, False, {"memory": 0, "results": 0}
        while len(counted) < len(sections):
            it.cycle += 1
            assert it.cycle - it.event < LIMIT, f"nothing occurs any more after {it.log[-3:]}"
            # The slot.
            there = it.taken < len(sections) and it.cycle >= next_at
            ctx.set(dut.i.valid, int(there))
            if there:
                ctx.set(dut.i.payload, sections[it.taken])
            # Units accept a start after a while.
            offers = {name: ctx.get(getattr(dut, f"o_{name}").valid) for name in ("memory", "results")}
            for name, offer in offers.items():
                if offer and not offered[name]:
                    it.note(f"{name} offered")
            offered = offers
            for name in UNITS:
                stream = getattr(dut, f"o_{name}")
                if ctx.get(stream.valid):
                    starts[name] = it.pause() if starts[name] is None else starts[name] - 1
                ctx.set(stream.ready, int(starts[name] is not None and starts[name] <= 0))
            # What is in flight.
            leaves = bool(done_at) and done_at[0] <= it.cycle
            enters = cells > 0 and len(done_at) < 20 and it.draw.random() < 0.5
            final_now = begun == len(UNITS) and not final and it.draw.random() < 1 / (1 + slow)
            ctx.set(dut.enters, int(enters))
            ctx.set(dut.leaves, int(leaves))
            ctx.set(dut.final, int(final_now))
            # No request follows, some time before the final item.
            closed = closed or (begun == len(UNITS) and not final and it.draw.random() < 2 / (2 + slow))
            ctx.set(dut.closed, int(closed and not final))
            # The drained memory system has given up its last patch one cycle before at the latest.
            ctx.set(dut.drained, int(cells == 0))
            # A read-out begins when the one before is over.
            it.reading = max(0, it.reading - 1)
            ctx.set(dut.o_results.ready, int(it.reading == 0))
            if ctx.get(dut.free):
                assert not there, "no section is requested while one waits"
                assert final or not begun or (closed and not cells), "none is requested before the present one ends"
                it.early += closed and not final
                it.requests.append(it.cycle)
            for name in UNITS:
                stream = getattr(dut, f"o_{name}")
                if ctx.get(stream.valid) and ctx.get(stream.ready):
                    if name in ("memory", "intersection"):
                        assert not cells + len(done_at), f"{name} starts while the earlier section is in flight"
                    else:
                        assert begun >= 2, f"{name} starts after the memory system and the intersection unit"
                    begun, starts[name] = begun + 1, None
                    it.note(name)
                    if name == "intersection":
                        it.tiles.append(ctx.get(dut.tiles_across))
            if ctx.get(dut.i.ready) and there:
                assert begun == len(UNITS), "the slot is given free when all units have begun"
                it.note("taken")
                it.taken, next_at = it.taken + 1, it.cycle + 1 + late
            if ctx.get(dut.o_results.valid) and ctx.get(dut.o_results.ready):
                assert (final, cells + last, done_at) == (True, 0, []), "a cast ends after its last cell and patch"
                it.note("results")
                counted.append(ctx.get(dut.cycles))
                it.reading, begun, final, closed = it.pause() * read_out, 0, False, False
            if enters:
                done_at.append(max([it.cycle + 1 + it.pause() * 4, *done_at]))
                cells -= 1
            if leaves:
                done_at.pop(0)
            # A cell that leaves together with the final item is counted a cycle later.
            cells, last = cells + last, final_now and it.draw.random() < 0.4
            if final_now:
                final = True
                it.note("final")
            if begun == len(UNITS) and not final and it.draw.random() < 0.4:
                cells += 1
            await ctx.tick()
        for _ in range(20):
            ctx.set(dut.i.valid, 0)
            ctx.set(dut.enters, 0)
            ctx.set(dut.leaves, 0)
            ctx.set(dut.final, 0)
            assert not ctx.get(dut.o_results.valid), "each cast ends once"
            await ctx.tick()
        settings["busy"] = ctx.get(dut.busy)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(units)
    simulator.run()
    assert not settings["busy"]
    return it, counted


def sections_of(count, seed):
    draw = random.Random(seed)
    side = 1 << CONFIG.icu.side_bits
    found = []
    for _ in range(count):
        first, end = sorted(draw.sample(range(side + 1), 2))
        found.append({"first_column": first, "end_column": end, "first_row": 0, "end_row": 1 + draw.randrange(side)})
    return found


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.sim) for seed in (1, 2, 3))])
@pytest.mark.parametrize("slow", [0, 6])
@pytest.mark.parametrize("late", [0, 40])
def test_each_section_is_cast_once_in_order(seed, slow, late):
    sections = sections_of(12, seed)
    it, counted = run(sections, seed=seed, slow=slow, late=late)
    side = 1 << CONFIG.icu.tile_bits
    assert it.tiles == [-(-(one["end_column"] - one["first_column"]) // side) for one in sections]
    assert [what for _, what in it.log].count("results") == len(counted) == len(sections)
    assert it.requests or late == 0, "a cluster without a section requests one"
    assert it.early or not (late and slow), "the next section is requested before the present one ends"


def test_few_cycles_lie_between_sections():
    """The next section starts in units that are ready 2 cycles after the read-out of the one before has begun."""
    it, _ = run(sections_of(12, 5), seed=5, slow=0)
    ends = [cycle for cycle, what in it.log if what == "results"]
    starts = [cycle for cycle, what in it.log if what == "memory"]
    assert {start - end for end, start in zip(ends, starts[1:], strict=False)} == {2}
    assert starts[0] - 1 == documented_latency(SectionCast, CONFIG)


def test_the_cycles_of_a_cast_are_counted():
    """From the start of its units to the end of its last patch; the wait for the read-out does not count."""
    it, counted = run(sections_of(8, 6), seed=6, slow=6, read_out=100)
    begins, ends, over = ([cycle for cycle, what in it.log if what == name] for name in (
        "memory offered", "results offered", "results"))
    assert over != ends, "some wait"
    assert counted == [end - begin for begin, end in zip(begins, ends, strict=True)]
