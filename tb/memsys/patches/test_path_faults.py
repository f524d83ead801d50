"""Faults of the path from cells to vertices, one upon the other: what is lost is what failed, nothing leaks, and the
next section is right.
"""

import random

import pytest

from hw.memsys.patches.path_formats import RequestKind
from tb.lib.configurations import config_of
from tb.lib.seed import NIGHTS, SEED
from tb.memsys.path_faults import FaultBench, Faults, Scene

CONFIG = config_of({
    "memsys.store_patches": 8, "memsys.store_requests": 4, "memsys.bus_requests": 4, "memsys.reply_ids": 2,
    "memsys.scene_cells": 64, "memsys.own_cells": 16, "memsys.own_entries": 64, "memsys.own_patches": 16,
    "icu.patch_bits": 8, "memory.timeout_bits": 5})
# Cells from 16 on are read from the bus. A third of the patches is here, a third at the other cluster.
CELLS, PATCHES = (0, 1, 16, 17, 18), 12
SCENE = Scene(lists={cell: tuple((2 * k + step) % PATCHES for step in (0, 1, 2, 5)) for k, cell in enumerate(CELLS)},
              residence={patch: (patch % 3, patch // 3) for patch in range(PATCHES) if patch % 3 != 2})
REMOTE, BUS = ([patch for patch in range(PATCHES) if patch % 3 == which] for which in (1, 2))
# Of the first cell two patches of the bus and one of the other cluster; the last cell is one of the bus.
TOGETHER = Scene(lists={0: (1, 2, 5), 1: (3,), 16: (4,)}, residence={1: (1, 0), 4: (1, 1)})


@pytest.fixture(scope="module")
def bench():
    return FaultBench(CONFIG, SCENE)


@pytest.mark.parametrize("loads", [False, True])
def test_a_cell_and_a_patch_that_are_lost_together_are_lost_each(loads):
    """The reply for the cell ends before that for the patch, with it, and after it; vertices of the bus wait for those
    of the network.
    """
    bench = FaultBench(CONFIG, TOGETHER)

    async def script(bench):
        await bench.load()
        for after in range(54, 58):
            delay = {(None, 1): 26, (RequestKind.PATCH, 2): 20, (RequestKind.CELL, 16): after}
            await bench.section((16, 0), seed=1, faults=Faults(parts={(16, 0)}, patches={5}), delay=delay)
            await bench.clear()
            if loads:
                await bench.load()
            else:
                await bench.section((0, 1), seed=2)
                await bench.reset()

    bench.run(script)


def drawn(number):
    """Two or three faults."""
    draw = random.Random(f"{SEED} {number}")
    kinds = draw.choices(("part", "patch", "void", "cell", "bus", "network"), (4, 4, 1, 1, 1, 1), k=draw.choice((2, 3)))
    made = {"parts": set(), "patches": set(), "void": set(), "cells": []}
    silent = [None, None]
    for kind in kinds:
        if kind == "part":
            made["parts"].add((draw.choice(CELLS[2:]), draw.randrange(2)))
        elif kind == "patch":
            made["patches"].add(draw.choice(BUS))
        elif kind == "void":
            made["void"].add(draw.choice(REMOTE))
        elif kind == "cell":
            made["cells"].append(draw.randrange(20, 64))
        else:
            silent[kind == "network"] = draw.randrange(6)
    return draw, Faults(**made, silent=tuple(silent))


@pytest.mark.parametrize("count", [
    2, pytest.param(8, marks=pytest.mark.sim), pytest.param(100 * NIGHTS, marks=pytest.mark.nightly)])
def test_two_and_three_faults(bench, count):
    for number in range(count):
        draw, faults = drawn(number)

        async def script(bench, draw=draw, faults=faults):
            await bench.load()
            cells = draw.sample(CELLS, len(CELLS))
            await bench.section(cells, seed=draw.getrandbits(30), faults=faults, delay=draw.choice((1, 4, 12)))
            if faults.silent != (None, None):
                await bench.reset()
            await bench.clear()
            if draw.random() < 0.5:
                await bench.load()
            await bench.section(cells, seed=draw.getrandbits(30))

        try:
            bench.run(script)
        except BaseException as error:
            error.add_note(f"SEED={SEED}, faults {number}: {faults}")
            raise
