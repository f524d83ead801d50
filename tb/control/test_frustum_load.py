"""What an image says of the rays of a phase comes to the units as their benches give it to them."""

import random

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import PRESETS
from golden.engine.frustum import screen_record
from golden.engine.memory_map import GRID_RAY_BITS, GRID_SHAPE_BITS, WEIGHT_BITS, phase_image
from golden.engine.schedule.phase import schedule
from golden.scene.open import open_scene
from hw.control.frustum_load import FrustumLoad
from hw.ctu.ctu_formats import CtuFormats
from hw.icu.icu_formats import IcuFormats, TableKind
from hw.lib.payload import pack, unpack
from hw.memsys.load.image_layout import RegionNumber, halves
from radiosity.flow.package.example.frustum_load import table_writes
from radiosity.flow.package.example.grid_load import unit_writes
from radiosity.flow.package.example.image_words import words
from tb.golden.engine.schedule.scenes import Case, case
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"ctu.subshell_bits": 10})
CLUSTER = 1


@pytest.fixture(scope="module", params=["hemisphere", "screen"])
def given(request):
    made, weights = case("cornell", rays=(64, 16), cell=0.25), None
    if request.param == "screen":
        screen = Screen(camera=open_scene("cornell").camera, width=60, height=45)
        made = Case(made.geometry, made.shelling, screen_record(screen, made.geometry.coordinates))
    else:
        weights = Hemisphere(64, 16).polar_weights
    plan = schedule(made.record, made.geometry, made.shelling.table, CONFIG, clusters=2, ratio=16)
    image = phase_image([made.record], made.geometry, made.shelling.table, CONFIG, weights=weights, plan=plan)
    return made, weights, image, plan.partition.sections[CLUSTER]


def load(items):
    """What comes out, stream by stream, and what stays; the taker of the tables stalls at random."""
    draw, dut = random.Random(3), FrustumLoad(config=CONFIG)
    bench = ScheduleBench(dut, watchdog=40_000, watched=["cells", "subshells"])
    found = bench.run(Schedule(items={"i": [(int(draw.random() < 0.1), item) for item in items]},
                               stalls={"o_table": [int(draw.random() < 0.3) for _ in items]}))
    return found, {"cells": unpack(dut.cells.shape(), bench.history["cells"][-1]),
                   "subshells": bench.history["subshells"][-1]}


def test_tables_and_numbers(given):
    made, weights, image, section = given
    found, numbers = load(list(words(image, CLUSTER)))
    record, config = made.record, CONFIG
    table_write, grid_write = IcuFormats(CONFIG).table_write, CtuFormats(CONFIG).grid_table_write

    # Each write names its entry, so the order of a table's writes is free; none may be missing or come twice.
    def ordered(items, shape):
        return sorted(pack(shape, item) for item in items)

    tables = table_writes(record, config, np.zeros(record.rows, int) if weights is None else weights)
    if record.is_screen:
        # There is a word for it.
        tables += [{"kind": 2, "index": row, "data": 0} for row in range(record.rows)]
    assert ordered(found["o_table"], table_write) == ordered(tables, table_write)
    unit = made.shelling.cluster(record, section).traversal
    assert ordered(found["o_grid"], grid_write) == ordered(unit_writes(unit, config), grid_write)
    listed = image.subshells(CLUSTER).tolist()
    assert found["o_subshell"] == [{"address": address, "patch": patch, "shell": shell}
                                   for address, (patch, shell) in enumerate(listed)]
    assert listed or record.is_screen

    assert numbers == {"cells": made.shelling.table.shape.tolist(), "subshells": len(listed)}


def test_a_number_follows_its_word_by_two_cycles():
    word, is_high = next(iter(halves("cell_grid", "shape")))
    bench = ScheduleBench(FrustumLoad(config=CONFIG), watched=["cells"])
    bench.run(Schedule(items={"i": [(0, {"region": RegionNumber.CELL_GRID.value, "record": 0, "word": word,
                                         "data": 5 << 32 * is_high})]}))
    (cycle,) = bench.cycles["i"]
    assert [*map(bool, bench.history["cells"][:cycle + 2])] == [False] * (cycle + 1) + [True]


def test_numbers_are_those_of_the_last_image(given):
    image = given[2]
    items, cells = list(words(image, CLUSTER)), RegionNumber.CELL_GRID.value
    others = [item | {"data": 2 << 32 | 1} if item["region"] == cells else item for item in items]
    _, numbers = load(others + [item for item in items if item["region"] != RegionNumber.CLUSTERS.value])
    assert numbers == {"cells": image["cell_grid"]["shape"][0].tolist(), "subshells": len(image.subshells(CLUSTER))}


def word(region, record, number, data):
    """A word of a record."""
    return {"region": RegionNumber[region].value, "record": record, "word": number, "data": data}


def test_the_largest_numbers_come_through():
    ctu, icu, weight = CONFIG.ctu, CONFIG.icu, (1 << WEIGHT_BITS) - 1
    listed, shell, shape = 1 << ctu.subshell_bits, 1 << ctu.shell_bits, (1 << GRID_SHAPE_BITS) - 1
    side, rays = 1 << icu.side_bits, (1 << GRID_RAY_BITS) - 1
    found, numbers = load([
        word("CELL_GRID", 0, 2, shape << 32 | shape), word("CELL_GRID", 0, 3, shape),
        word("CLUSTERS", 0, 0, listed << 32), word("ROWS", side - 1, 1, weight),
        *(word("SHELLS", shell - 3, number, 0) for number in range(4)), word("SHELLS", shell - 3, 4, rays),
        word("SUBSHELLS", listed - 1, 0, 7 << 32 | 3),
        # A list that is too long is refused when it is cast; what does not fit the table is not written.
        word("SUBSHELLS", listed, 0, 9 << 32 | 9)])
    assert found["o_table"] == [{"kind": TableKind.WEIGHT.value, "index": side - 1, "data": weight}]
    assert found["o_subshell"] == [{"address": listed - 1, "patch": 3, "shell": 7}]
    (grid,) = found["o_grid"]
    assert grid["index"] == shell - 1
    assert unpack(CtuFormats(CONFIG).grid_shell, grid["data"])["first_ray"] == rays
    assert numbers == {"cells": [shape] * 3, "subshells": listed}


def test_latency():
    assert documented_latency(FrustumLoad, CONFIG) == FrustumLoad.latency == 0
