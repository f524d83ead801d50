"""The table of tests and rays per second."""

from dataclasses import replace

import numpy as np
import pytest

from golden.cast.embree import Embree
from golden.cast.shelling import Shelling
from golden.config import PRESETS
from hw.history import read_history
from hw.simulator.simulation_config import simulation_config
from radiosity.benchmarks.engine import prepare_cast
from radiosity.benchmarks.throughput import cluster_luts, rays_of, row_of


def test_rates_are_of_cycles_and_the_clock():
    found = {"patches": 20, "rays": 1000, "cast_cycles": 4000, "tests_per_ray": 2.5, "efficiency": 0.625}
    row = row_of("lobby", found, mhz=80, luts=40_000, embree=5e6, same=0.9991)
    # 2500 tests and 1000 rays in 50 microseconds.
    assert [cell.strip() for cell in row.split("|")[1:-1]] == [
        "lobby", "20", "1000", "2500", "4000", "0.625", "0.250", "50.0", "250", "20.00", "500", "5.00", "0.25", "99.91"]
    unknown = row_of("lobby", found, mhz=80, luts=None, embree=5e6, same=0.9991)
    assert unknown == row.replace(" 500 ", "  ")


def test_luts_are_those_of_the_last_record_of_a_cluster(monkeypatch):
    known = next(record for record in read_history() if record.family == "ecp5" and record.preset == "small")
    cluster = replace(known, parameters="noc.columns=1 noc.rows=1", block="cluster", unit="Cluster", lut=1234)
    other = replace(cluster, parameters="icu.slots=16 noc.columns=1 noc.rows=1", lut=7)
    history = [replace(cluster, lut=9), cluster, other]
    monkeypatch.setattr("radiosity.benchmarks.throughput.read_history", lambda: history)
    assert cluster_luts("small", ()) == 1234
    assert cluster_luts("small", ("icu.slots=16",)) == 7
    assert cluster_luts("tiny", ()) is None


@pytest.mark.parametrize("scene", ["cornell", "lobby"])
def test_the_rays_are_the_machines(scene):
    """Another caster meets the same patches with them."""
    config = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")
    prepared = prepare_cast(config, scene, cell=0.125, rays=(32, 8))
    request = prepared.request
    hits = Shelling.of_cells(request.geometry, request.table, config).cast(prepared.records[0])[0].patch
    assert len(set(hits)) > 5
    assert np.mean(Embree(prepared.scene).nearest_patches(rays_of(prepared)) == hits) > 0.99
