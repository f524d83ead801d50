from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from golden.config import PRESETS
from golden.memory_map import COORDINATE_BITS
from hw.memsys.patch_decoder import FIRST_VERTEX, PatchDecoder
from tb.lib.schedules import SETTINGS
from tb.memsys.patch_words import words_of

CONFIG = PRESETS["small"]
COORDINATE = st.integers(0, (1 << COORDINATE_BITS) - 1)
PATCH = st.tuples(st.integers(0, (1 << 32) - 1), st.integers(0, (1 << 32) - 1),
                  st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE), min_size=4, max_size=4))


@SETTINGS
@given(st.lists(st.tuples(PATCH, st.lists(st.integers(0, 2), min_size=6, max_size=6)), min_size=1, max_size=4))
def test_patches_come_back(patches):
    dut, found = PatchDecoder(config=CONFIG), []

    async def bench(ctx):
        for (patch, surface, vertices), gaps in patches:
            heads, corners = None, {}
            for word, (data, gap) in enumerate(zip(words_of(patch, surface, vertices), gaps, strict=True)):
                # What stands at the port without ``valid`` does not matter.
                ctx.set(dut.valid, 0)
                ctx.set(dut.word, 1)
                ctx.set(dut.data, (1 << 64) - 1)
                for _ in range(gap):
                    await ctx.tick()
                ctx.set(dut.valid, 1)
                ctx.set(dut.word, word)
                ctx.set(dut.data, data)
                if word == 0:
                    heads = ctx.get(dut.patch), ctx.get(dut.surface)
                if word >= FIRST_VERTEX:
                    corners[ctx.get(dut.index)] = tuple(ctx.get(dut.vertex[axis]) for axis in range(3))
                await ctx.tick()
            found.append((*heads, [corners[index] for index in range(4)]))

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == [patch for patch, _ in patches]
