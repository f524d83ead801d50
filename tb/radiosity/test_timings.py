"""Latencies and capacities by which machines are simulated: what follows each parameter, and that nothing else does.

The cycles of simulated casts and jobs are compared with the hardware's elsewhere, for the configurations that are
built; these differences are those of all others too.
"""

from dataclasses import asdict

import pytest

from golden.engine.config import PRESETS
from hw.memsys.bus.lfu_placement import LfuPlacement
from hw.memsys.bus.set_placement import SetPlacement
from radiosity.machines.engine.job_latencies import bus_timing, job_timing, joint_timing, load_timing


def timings(changes=None, latency=10):
    config = PRESETS["tiny"].replace(changes or {})
    parts = {"job": job_timing(config, latency=latency), "load": load_timing(config, latency=latency),
             "joint": joint_timing(config), "bus": bus_timing(config, latency=latency)}
    return {(kind, name): value for kind, part in parts.items() for name, value in asdict(part).items()}


BEFORE = timings()
# A record of a patch is six words of 64 bits: five beats more than one of 512 bits.
WIDE = {("bus", "fetch"): -5, ("bus", "next_fetch"): -5}
LFU = LfuPlacement.latency - SetPlacement.latency


@pytest.mark.parametrize(("changes", "latency", "expected"), [
    # Where main memory is waited for.
    ({}, 110, dict.fromkeys([("job", "answer"), ("load", "trip"), ("load", "extents"), ("bus", "fetch"),
                             ("bus", "next_fetch")], 100)),
    ({"memory.data_bits": 512}, 10, WIDE | {("load", "burst"): 16 * (512 - 64) // 8}),
    ({"memory.data_bits": 512, "memory.burst_beats": 2}, 10, WIDE),
    ({"memsys.cache_policy": "lfu"}, 10, {("bus", "hit"): LFU, ("bus", "fetch"): LFU}),
    # Five flits of 72 bits are ten of half as many.
    ({"noc.flit_bits": 36}, 10, {("joint", "reply_flits"): 5}),
    ({"memsys.cache_fetches": 2, "memsys.bus_requests": 2, "noc.requests": 2}, 10, {
        ("bus", "fetches"): 2 - 8, ("bus", "outstanding"): 2 - 4, ("joint", "outstanding"): 2 - 4}),
    ({"noc.columns": 4, "noc.rows": 2, "memsys.cache_policy": "direct"}, 10, {})])
def test_what_follows_a_parameter(changes, latency, expected):
    after = timings(changes, latency)
    assert {name: after[name] - value for name, value in BEFORE.items() if after[name] != value} == expected
