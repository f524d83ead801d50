"""A whole intersection unit casts a section of a shadow frustum, then a screen: bits and hits are golden's."""

from dataclasses import fields

import numpy as np
import pytest

from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.ctu.sector import Sector
from golden.engine.frustum.record import FrustumRecord
from golden.engine.jobs.result_formats import pack_bits
from hw.icu.intersection_unit import IntersectionUnit
from radiosity.flow.package.example.frustum_load import frustum_payload, table_writes
from tb.golden.engine.cast.drawn_shadows import drawn_frustum
from tb.icu.listed_rays import FIELDS, expected
from tb.icu.unit_bench import section_hits, vertices
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench

CONFIG = config_of({"icu.rays": 256, "icu.side_bits": 6, "icu.patch_bits": 8, "icu.generation_bits": 2,
                    "icu.shadow_bits": 8})
# From a frustum to its patches, to its read-out and to the next frustum: more than each of them takes.
PATCHES, READ_OUT, PERIOD = 260, 560, 850


def hard_frustum():
    """The patches that a frustum sees, few of them, the frustum, and a screen of the same grid."""
    geometry, record, _ = drawn_frustum(0, bits=4)
    screen = FrustumRecord(**{field.name: getattr(record, field.name) for field in fields(FrustumRecord)})
    patch = NaiveFixed(geometry, CONFIG).cast(screen).patch
    return geometry[np.unique(patch[patch >= 0])], record, screen


def offered(times, items):
    """Items that begin to be offered in certain cycles, each list of them without gaps."""
    found, used = [], 0
    for time, some in zip(times, items, strict=True):
        found += [(time - used if k == 0 else 0, item) for k, item in enumerate(some)]
        used = time + len(some)
    return found


@pytest.mark.sim
def test_a_shadow_frustum_and_a_screen_in_the_other_bank():
    geometry, record, screen = hard_frustum()
    frusta = (record, Sector(2, 13, 3, 16)), (screen, Sector.whole(screen))
    naive, begins = NaiveFixed(geometry, CONFIG), (20, 20 + PERIOD)
    listed = expected(*frusta[0], CONFIG)
    rays = [{**dict(zip(FIELDS, ray or (0,) * 4, strict=True)), "is_ray": int(ray is not None),
             "last": int(k == len(listed) - 1)} for k, ray in enumerate(listed)]
    bench = ScheduleBench(IntersectionUnit(config=CONFIG), ["i_table", "i_frustum", "i_ray", "i_vertex", "i_read_out"],
                          ["o_done", "o_hit", "o_sum"], idle_limit=500)
    found = bench.run(Schedule(first={"i_table": table_writes(record, CONFIG)}, items={
        "i_frustum": offered(begins, [[frustum_payload(*one, CONFIG)] for one in frusta]),
        "i_ray": offered(begins[:1], [rays]),
        "i_vertex": offered([time + PATCHES for time in begins], [vertices(geometry, np.arange(len(geometry)))] * 2),
        "i_read_out": offered([time + READ_OUT for time in begins], [[0]] * 2)}))["o_hit"]
    blocked = naive.blocked(record)[record.listed] & np.array([ray is not None for ray in listed])
    assert 0.2 < blocked.mean() < 0.8
    words = np.frombuffer(pack_bits(blocked), "<u8").tolist()
    assert len(words) > 1
    assert [(one["is_word"], one["word"], one["column"], one["last"]) for one in found[:len(words)]] == [
        (1, word, k, int(k == len(words) - 1)) for k, word in enumerate(words)]
    golden, own = section_hits(naive.cast(screen), *frusta[1]), found[len(words):]
    assert 0.2 < (golden.patch >= 0).mean() < 0.8
    assert not any(ray["is_word"] for ray in own)
    assert [tuple(ray["hit"].values()) for ray in own] == list(zip(
        golden.inverse.tolist(), np.maximum(golden.patch, 0).tolist(), golden.u.tolist(), golden.v.tolist(),
        strict=True))
