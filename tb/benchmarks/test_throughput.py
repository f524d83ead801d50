"""The table of tests and rays per second."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.casting import REPEATS, SECONDS, shortest
from benchmarks.engine import prepare_cast
from benchmarks.throughput import EmbreeRates, clock_text, embree_rates, rays_of, recorded, row_of
from golden.cast.embree import Embree
from golden.cast.rays import Rays
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.flow.synthesis.history import read_history


def test_rates_are_of_cycles_and_the_clock():
    found = {"patches": 20, "rays": 1000, "cast_cycles": 4000, "tests_per_ray": 2.5, "efficiency": 0.625}
    embree = EmbreeRates(one=5e6, all=9e6, binding=2e6, same=0.9991)
    row = row_of("lobby", found, mhz=80, luts=40_000, embree=embree)
    # A ray in four cycles: 1000 rays in 50 microseconds, and 0.25 / 0.04 in a cycle of a million LUTs.
    assert row == ["`lobby`", "20", "1000", "2500", "4000", "0.625", "0.250", "6.2", "20.00", "500", "5.00", "9.00",
                   "2.00", "99.91"]
    assert row_of("lobby", found, mhz=None, luts=40_000, embree=embree) == [*row[:8], "", "", *row[10:]]
    assert row_of("lobby", found, mhz=80, luts=None, embree=embree) == [*row[:7], "", row[8], "", *row[10:]]


def test_a_clock_is_that_of_a_whole_machine(monkeypatch):
    """Of the last record of the same parameters; a cluster's has LUTs and no clock of a machine."""
    known = next(record for record in read_history() if record.family == "ecp5" and record.preset == "small")
    cluster = replace(known, parameters="noc.columns=1 noc.rows=1", block="cluster", unit="Cluster", lut=1234)
    engine = replace(cluster, block="engine", unit="Engine", lut=2000, seeds=(1, 2, 3), mhz=(40.0, 43.0, 41.0),
                     commit="abc")
    other = replace(cluster, parameters="icu.slots=16 noc.columns=1 noc.rows=1", lut=7)
    board = replace(engine, parameters="icu.slots=8 noc.columns=1 noc.rows=1", block="board", unit="BoardShell")
    history = [replace(cluster, lut=9), cluster, replace(engine, lut=1), engine, other, board]
    monkeypatch.setattr("benchmarks.throughput.read_history", lambda: history)
    assert list(recorded("small", ())) == [engine, cluster]
    assert list(recorded("small", ("icu.slots=16",))) == [other]
    # A bitstream's machine is a whole one; its clusters may be among what is given.
    assert list(recorded("small", ("noc.columns=1", "icu.slots=8"))) == [board]
    assert not list(recorded("tiny", ()))
    assert clock_text(engine).endswith("grade 6, median of seeds 1, 2, 3, commit abc")


def test_embree_casts_the_machines_rays():
    config = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")
    prepared = prepare_cast(config, "cornell", cell=0.125, rays=(32, 8))
    hits = Shelling.of_cells(prepared.request.geometry, prepared.request.table, config).cast(prepared.records[0])[0]
    found = embree_rates(prepared, hits.patch)
    assert found.same > 0.99
    assert min(found.one, found.all, found.binding) > 0


def test_rates_are_of_the_rays_that_are_cast(monkeypatch):
    """Embree's own interface takes a multiple of 8 rays; embreex takes all of them."""
    config = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")
    prepared = prepare_cast(config, "cornell", cell=0.125, rays=(32, 8))
    rays = rays_of(prepared)
    cut = Rays(rays.origin[:-3], rays.direction[:-3], source=rays.source[:-3])
    monkeypatch.setattr("benchmarks.throughput.rays_of", lambda prepared: cut)
    for module in "casting", "throughput":
        monkeypatch.setattr(f"benchmarks.{module}.shortest", lambda run, clock: (2.0, run()))
    found = embree_rates(prepared, np.zeros(len(cut), dtype=np.int64))
    assert [found.one, found.all, found.binding] == pytest.approx([124, 124, 126.5])


@pytest.mark.parametrize(("seconds", "runs"), [((3, 1, 2), 3), ((SECONDS / 4.5,) * 9, 5)])
def test_runs_are_repeated_until_they_are_enough_and_take_long_enough(seconds, runs):
    clock, results = [0.0], []

    def run():
        clock[0] += seconds[len(results)]
        results.append(len(results))
        return results[-1]

    shown, result = shortest(run, lambda: clock[0])
    assert (shown, result, len(results)) == (pytest.approx(min(seconds)), runs - 1, runs)
    assert runs >= REPEATS


@pytest.mark.parametrize("scene", ["cornell", "lobby"])
def test_the_rays_are_the_machines(scene):
    """Another caster meets the same patches with them."""
    config = simulation_config(PRESETS["tiny"], clusters=1, topology="mesh")
    prepared = prepare_cast(config, scene, cell=0.125, rays=(32, 8))
    request = prepared.request
    hits = Shelling.of_cells(request.geometry, request.table, config).cast(prepared.records[0])[0].patch
    assert len(set(hits)) > 5
    assert np.mean(Embree(prepared.scene).nearest_patches(rays_of(prepared)) == hits) > 0.99
