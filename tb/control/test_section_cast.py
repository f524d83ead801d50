"""Sections one after the other in units that take their time: none starts early, none is lost, few cycles between."""


from golden.engine.config import PRESETS
from hw.control.section_cast import PATCHES, SectionCast
from tb.lib.bench import Bench
from tb.lib.simulator import simulator_of

UNITS = ("memory", "intersection", "traversal", "near")


class TestSectionCast(Bench):
    component, variants, span = SectionCast, ({},), 400

    def model(self, config):
        """What a section waits for, step by step."""
        side = 1 << config.icu.tile_bits
        step, cycles, offered, over, settled, self.patches = "wait", 0, 0, False, False, 0
        starts = dict.fromkeys(UNITS, False)
        given = yield
        while True:
            begins = step == "wait" and given.i is not None and offered >= 1
            ready = step == "traverse" and not (starts["traversal"] or starts["near"])
            busy, results, idle = step != "wait" or begins, step == "results", given.drained and not self.patches
            columns = given.i and given.i["end_column"] - given.i["first_column"]
            outputs = {
                "i": ready, "begins": begins, "o_results": 0 if results else None, "busy": busy, "cycles": cycles,
                "free": given.i is None and (over or (given.closed and given.drained) or not busy), "idle": idle,
                # The tiles follow a section by two registers.
                "tiles_across": -(-columns // side) if given.i and offered >= 2 else None,
                **{f"o_{name}": 0 if start else None for name, start in starts.items()}}
            was_over = over
            if begins:
                cycles = 0
            elif busy and not results:
                cycles += 1
            over = not begins and (over or given.ends)
            pending = {name: start and not getattr(given, f"o_{name}") for name, start in starts.items()}
            if begins:
                pending |= {"memory": True, "intersection": True}
                step = "begin"
            elif step == "begin" and not (starts["memory"] or starts["intersection"]):
                pending |= {"traversal": True, "near": True}
                step = "traverse"
            elif ready:
                step = "cast"
            elif step == "cast":
                # A cell that leaves together with the final item is counted a cycle later.
                step, settled = ("results", False) if settled and idle else ("cast", was_over and idle)
            elif results and given.o_results:
                step = "wait"
            starts, offered = pending, 0 if given.i is None or ready else offered + 1
            self.patches += given.enters - given.leaves
            given = yield outputs

    def items(self, name, shape, random):
        """Sections, with a column at least."""
        side = 1 << self.config().icu.side_bits
        while True:
            first, end = sorted(random.sample(range(side + 1), 2))
            yield {"first_column": first, "end_column": end, "first_row": 0, "end_row": 1 + random.randrange(side)}

    def drive(self, given, random):
        """Patches that have entered leave; all else comes at any time."""
        given.enters, given.leaves = random.random() < 0.2, self.patches > 0 and random.random() < 0.4
        given.ends, given.drained = random.random() < 0.1, random.random() < 0.8


def test_as_many_patches_as_are_counted():
    """Nothing is in flight only when each of them has left."""
    dut = SectionCast(config=PRESETS["tiny"])

    async def bench(ctx):
        ctx.set(dut.drained, 1)
        for moves, left in (dut.enters, range(PATCHES)), (dut.leaves, range(PATCHES, 0, -1)):
            ctx.set(moves, 1)
            for patches in left:
                assert ctx.get(dut.idle) == (patches == 0), f"{patches} patches"
                await ctx.tick()
            ctx.set(moves, 0)
        assert ctx.get(dut.idle)

    simulator_of(dut, bench).run()
