import numpy as np
import pytest

from golden.engine.ctu.sector import Sector
from golden.engine.frustum.ray_list import END_BIT, X_BIT, Y_BIT, pack_rays
from hw.icu.ray_list import RayList
from radiosity.flow.package.example.frustum_load import frustum_payload
from tb.icu.listed_rays import FIELDS, expected
from tb.icu.shadow_frustum import random_shadow
from tb.icu.vectors import SHADOWS
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency


def entries(words, config):
    """Words of main memory as `IcuFormats.ray_entry`."""
    place, end = config.numbers.direction_fraction + 1, config.numbers.inverse.width
    return [{name: word >> first & (1 << bits) - 1 for name, first, bits in (
        ("x", X_BIT, place), ("y", Y_BIT, place), ("end", END_BIT, end))} for word in words.tolist()]


@pytest.mark.parametrize("changes", SHADOWS, ids=["default", "narrow"])
@pytest.mark.parametrize("section", [None, Sector(3, 14, 5, 16), Sector(0, 1, 15, 16)], ids=str)
def test_rays_of_a_section_have_their_places(changes, section):
    config, random = config_of({**changes, "icu.product_registers": 3}), np.random.default_rng(4)
    record = random_shadow(random, config, bits=4)
    section, words = section or Sector.whole(record), pack_rays(record, record.listed)
    bench = ScheduleBench(RayList(config=config), idle_limit=40)
    load = [{"address": k, "entry": entry} for k, entry in enumerate(entries(words, config))]
    random.shuffle(load)
    found = bench.run(Schedule(first={"i_load": load}, items={"i": [(3, len(words)), (0, 2), (0, 0)]},
                               stalls={"o": [0, 0, 7, *random.integers(0, 2, 30).tolist()]}),
                      frustum=frustum_payload(record, section, config))["o"]
    rays = expected(record, section, config)
    assert any(rays)
    assert [tuple(one[name] for name in FIELDS) if one["is_ray"] else None for one in found] == [*rays, *rays[:2], None]
    assert [k for k, one in enumerate(found) if one["last"]] == [len(words) - 1, len(words) + 1, len(words) + 2]
    assert bench.cycles["o"][0] - bench.cycles["i"][0] == documented_latency(RayList, config)


def test_a_ray_that_ends_at_once_is_none():
    config = config_of(SHADOWS[0])
    record = random_shadow(np.random.default_rng(4), config, bits=4)
    load = [{"address": 0, "entry": {"x": 0, "y": 0, "end": config.numbers.inverse.high}},
            {"address": 1, "entry": {"x": 0, "y": 0, "end": config.numbers.inverse.high - 1}}]
    bench = ScheduleBench(RayList(config=config), idle_limit=40)
    found = bench.run(Schedule(first={"i_load": load}, items={"i": [(0, 2)]}),
                      frustum=frustum_payload(record, Sector.whole(record), config))["o"]
    assert [one["is_ray"] for one in found] == [0, 1]
    assert np.diff(bench.cycles["o"]).tolist() == [1]
