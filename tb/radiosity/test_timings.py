"""Latencies and capacities by which machines are simulated, of some configurations.

The cycles of simulated casts and jobs are compared with the hardware's elsewhere, for the configurations that are
built; these values are those of all others too.
"""

import json
from dataclasses import asdict
from pathlib import Path

import pytest

from golden.config import PRESETS
from radiosity.job_timing import bus_timing, job_timing, joint_timing, load_timing

RECORD = Path(__file__).with_name("timings.json")
CONFIGS = {**{name: PRESETS[name] for name in ("tiny", "small", "paper", "thesis")},
           "wide": PRESETS["small"].replace({"memory.data_bits": 512, "memory.burst_beats": 2,
                                             "memsys.cache_policy": "lfu"}),
           "narrow": PRESETS["tiny"].replace({"memory.data_bits": 64, "memsys.cache_policy": "direct",
                                              "noc.columns": 4, "noc.rows": 2})}


def timings(name):
    config = CONFIGS[name]
    return {"job": asdict(job_timing(config, latency=10)), "load": asdict(load_timing(config, latency=10)),
            "joint": asdict(joint_timing(config)), "bus": asdict(bus_timing(config, latency=10))}


@pytest.mark.parametrize("name", CONFIGS)
def test_latencies_of_a_configuration(name):
    assert timings(name) == json.loads(RECORD.read_text())[name]


def test_main_memorys_latency_counts_where_it_is_waited_for():
    config = PRESETS["tiny"]
    slow = {"job": asdict(job_timing(config, latency=110)), "load": asdict(load_timing(config, latency=110)),
            "bus": asdict(bus_timing(config, latency=110))}
    fast = timings("tiny")
    changed = {(kind, name): slow[kind][name] - fast[kind][name]
               for kind, values in slow.items() for name in values if values[name] != fast[kind][name]}
    assert changed == {("job", "answer"): 100, ("load", "trip"): 100, ("load", "extents"): 100, ("bus", "fetch"): 100,
                       ("bus", "next_fetch"): 100}


if __name__ == "__main__":
    RECORD.write_text(json.dumps({name: timings(name) for name in CONFIGS}, indent=1) + "\n")
