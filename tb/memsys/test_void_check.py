"""Patches of which all vertices are 0, among others, and the coordinates that no patch of a scene has."""

import numpy as np
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from golden.config import PRESETS, Numbers
from golden.scene.builtin import builtin_scene
from golden.scene.patch_geometry import PatchGeometry
from hw.memsys.void_check import VERTICES, VoidCheck
from tb.lib.schedules import SETTINGS

CONFIG = PRESETS["tiny"]
ZERO, HIGH = (0, 0, 0), CONFIG.numbers.scene.high
VERTEX = st.sampled_from((ZERO, ZERO, ZERO, ZERO, (1, 0, 0), (0, HIGH, 0), (0, 0, 1), (0, 0, HIGH ^ HIGH >> 1)))


@SETTINGS
@given(patches=st.lists(st.lists(VERTEX, min_size=VERTICES, max_size=VERTICES), max_size=5),
       moves=st.lists(st.booleans(), min_size=40, max_size=40))
def test_a_patch_is_void_if_all_four_vertices_are_0(patches, moves):
    """Whatever is there in the cycles in which none moves."""
    dut, vertices, found = VoidCheck(config=CONFIG), [one for patch in patches for one in patch], []

    async def bench(ctx):
        for moving in [*moves, *[True] * len(vertices)]:
            if len(found) == len(vertices):
                return
            ctx.set(dut.vertex, vertices[len(found)] if moving else ZERO)
            ctx.set(dut.moves, moving)
            void = ctx.get(dut.void)
            if moving:
                found.append((ctx.get(dut.index), void))
            else:
                assert not void
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == [(index, index == VERTICES - 1 and {*patch} == {ZERO})
                     for patch in patches for index in range(VERTICES)]


def test_no_coordinate_of_a_scene_is_0():
    """With as few bits as numbers can have."""
    for bits in (12, 24):
        numbers = Numbers(scene_bits=bits, vector_fraction=10)
        vertices = PatchGeometry.of(builtin_scene("cornell"), numbers).vertices
        assert vertices.min() > 0
        assert np.count_nonzero(vertices == vertices.min(axis=(0, 1))), "vertices at the lower corner among them"
