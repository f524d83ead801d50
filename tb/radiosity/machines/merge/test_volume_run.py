"""Volumes are drawn by nodes of any number, and reported with balance, growth and speedup."""

from functools import cache

import numpy as np
import pytest

from radiosity.machines.merge.screen_split import SPLITTERS
from radiosity.machines.merge.volume_run import PARSYTEC, STEP, simulate_volume
from radiosity.machines.merge.work_weights import WorkWeights
from tb.radiosity.machines.merge.marched import small_volume

pytestmark = pytest.mark.usefixtures("interpreted")


@cache
def run(splitter="hs", nodes=8, **keywords):
    return simulate_volume(small_volume(1)[1], splitter, nodes=nodes, **keywords)


def test_operations_are_weighted_faces_spans_pixels_and_steps():
    found, weights = run("rrs"), WorkWeights()
    expected = (weights.triangle * found.faces + weights.span * found.work.spans + weights.pixel * found.work.pixels
                + STEP * found.work.steps)
    assert np.array_equal(found.operations, expected)
    assert found.speedup == found.alone / expected.max()
    assert found.time == (found.split_ends + expected * PARSYTEC.operation).max()


def test_balance_and_growth_are_by_faces():
    found = run("gs")
    assert found.balance == pytest.approx(found.faces.max() / (found.count / 8))
    assert found.growth == pytest.approx(found.faces.sum() / found.count - 1)


def test_one_node_has_all():
    found = run(nodes=1)
    assert (found.balance, found.growth, found.speedup) == (1, 0, 1)
    assert found.sent.sum() == 0
    assert found.alone == found.operations[0]


@pytest.mark.parametrize("splitter", SPLITTERS)
def test_reports_have_the_picture_of_one_node(splitter):
    report = run(splitter, is_weighted=False).report()
    assert report["picture"] == run(nodes=1).report()["picture"]
    assert (report["splitter"], report["weighted"], report["nodes"]) == (splitter, False, 8)
    assert report["seconds"] >= report["drawing"]["seconds"]
    assert report["speedup"] < report["drawing"]["speedup"]


def test_work_is_counted_without_samples():
    counted, drawn = run(is_sampled=False), run()
    assert counted.work.picture.max() == 0
    assert np.array_equal(counted.operations, drawn.operations)
    assert run(alone=12345).alone == 12345
