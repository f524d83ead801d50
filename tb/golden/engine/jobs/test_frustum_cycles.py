"""Predicted cycles of frusta: the model's of the samples, and means of these between them."""

from dataclasses import replace

import numpy as np
import pytest

from golden.engine.cast.shelling import Shelling
from golden.engine.jobs import frustum_cycles as module
from golden.engine.jobs.frustum_cycles import frustum_cycles
from golden.engine.schedule.cycle_model import CycleModel, stage_work
from tb.golden.engine.cast.drawn_shadows import drawn_frustum
from tb.golden.engine.jobs.jobs import SMALL, hemispheres, scene
from tb.golden.engine.schedule.scenes import CONFIG


def predicted(records, config):
    return frustum_cycles(records, scene().geometry, scene().shelling.table, config)


@pytest.fixture(scope="module")
def modelled():
    """Six frusta, and the model's cycles of each."""
    records, geometry, cycles = hemispheres(6, SMALL), scene().geometry, []
    shelling = Shelling.of_cells(geometry, scene().shelling.table, CONFIG, by_code=True)
    for record in records:
        model = CycleModel(CONFIG, patches=len(geometry))
        for work in stage_work(shelling, record, CONFIG):
            model.add(work)
        cycles.append(model.cycles)
    return records, np.array(cycles)


def test_few_frusta_are_all_modelled(modelled):
    records, cycles = modelled
    found = predicted(records, CONFIG)
    np.testing.assert_allclose(found, cycles, rtol=1e-6)
    assert len(np.unique(cycles)) > 1


def test_others_are_between_the_samples_and_most_like_the_nearest_one(modelled, monkeypatch):
    monkeypatch.setattr(module, "SAMPLES", 2)
    records, cycles = modelled
    found = predicted(records, CONFIG)
    samples = np.flatnonzero(np.isclose(found, cycles, rtol=1e-6))
    assert len(samples) == 2
    low, high = sorted(cycles[samples])
    assert (low - 1e-6 <= found).all()
    assert (found <= high + 1e-6).all()
    origins = np.array([record.origin for record in records], dtype=float)
    away = np.linalg.norm(origins[:, None] - origins[samples], axis=2)
    nearest = np.abs(found[:, None] - cycles[samples]).argmin(axis=1)
    np.testing.assert_array_equal(nearest, away.argmin(axis=1))


def test_a_ray_of_a_list_takes_a_cycle():
    """Rays that end nearly at once are blocked by nothing."""
    geometry, record, _ = drawn_frustum(1, bits=4)
    end, table = record.end.copy(), Shelling(geometry, CONFIG, cell=0.25).table
    end[np.flatnonzero(end == CONFIG.numbers.inverse.high)[:9]] -= 1
    few, more = (frustum_cycles([one], geometry, table, CONFIG) for one in (record, replace(record, end=end)))
    assert more - few == 9
    assert few > len(record.listed)


def test_frusta_may_have_more_rays_than_a_cluster(modelled):
    records, cycles = modelled
    tiny = CONFIG.replace({"icu.rays": 64})
    np.testing.assert_allclose(predicted(records, tiny), cycles, rtol=1e-6)
