import cocotb
import numpy as np
import pytest

from golden.cast.naive_fixed import NaiveFixed
from golden.ctu.sector import Sector
from golden.frustum import Hemisphere
from golden.icu.collector import collect
from golden.scene.builtin import builtin_scene
from hw.icu.intersection_unit import IntersectionUnit
from tb.bench.viewpoints import hard_records
from tb.golden.soups import soup
from tb.icu.unit_bench import UnitBench, section_hits
from tb.lib.clocking import start
from tb.lib.configurations import config_of
from tb.lib.pauses import PAUSES
from tb.lib.runner import options, simulate

MODULE = "tb.icu.test_intersection_unit"


def scene_of(name):
    return soup(int(name.removeprefix("soup "))) if name.startswith("soup ") else builtin_scene(name)


@cocotb.test()
async def frusta(dut):
    """Hemisphere and screens of a scene: hits and sums are golden's, field by field."""
    given = options()
    random = np.random.default_rng(given["seed"])
    config = config_of(given["changes"], given["preset"])
    scene = scene_of(given["scene"])
    geometry, records = hard_records(scene, origins=given["origins"], rays=given["rays"], pixels=given["pixels"],
                                     seed=given["seed"])
    await start(dut, cycles=given["cycles"])
    source, sink = (PAUSES[name] for name in given["pauses"])
    bench = UnitBench(dut, config, vertex_pauses=source(1), done_pauses=sink(2), hit_pauses=sink(3))
    naive = NaiveFixed(geometry, config)
    for record in records:
        section = Sector.whole(record)
        weights = None if record.is_screen else Hemisphere(*given["rays"]).polar_weights
        await bench.begin(record, section, weights)
        order = np.arange(len(geometry))
        if given["order"] == "random":
            random.shuffle(order)
        await bench.cast(geometry, order)
        counters = bench.counters()
        expected = section_hits(naive.cast(record), record, section)
        hits = await bench.hits(section)
        different = hits.differences(expected)
        assert len(different) == 0, f"{len(different)} rays of {len(record)} differ, the first is {different[0]}"
        dut._log.info("%s: %s", given["scene"], counters)
        assert counters["issued"] == counters["tested"] <= counters["visited"]
        assert counters["won"] <= counters["inside"] <= counters["tested"]
        if weights is not None:
            sums = await bench.collected(len(geometry))
            assert (sums == collect(expected.patch, np.repeat(weights, record.columns), len(geometry))).all()
        else:
            await bench.collected(1)


def run(name, *, scene, simulator="verilator", origins=1, rays=(64, 16), pixels=(60, 45), order="table",
        pauses=("none", "none"), changes=None, preset="tiny", cycles=400_000):
    changes = {"icu.patch_bits": 10, "icu.side_bits": 8, **(changes or {})}
    simulate(IntersectionUnit(config=config_of(changes, preset)), MODULE, ("frusta",), simulator=simulator, name=name,
             scene=scene, origins=origins, rays=rays, pixels=pixels, order=order, pauses=pauses, changes=changes,
             preset=preset, cycles=cycles)


@pytest.mark.parametrize("order", ["table", "random"])
def test_cornell(order):
    run(f"unit-cornell-{order}", scene="cornell", order=order)
