"""Numbers of a cluster's timing are checked."""

from dataclasses import asdict

import pytest

from golden.engine.config import PRESETS, Icu
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.cluster_timing import ClusterTiming


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"setup": -1}, ValueError, "Setup must be at least 0, not -1"),
    ({"cells": 0}, ValueError, "Cells must be at least 1, not 0"),
    ({"walk": 1.5}, TypeError, "Walk must be an int, not 1.5")])
def test_numbers_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        ClusterTiming(**{**asdict(cluster_timing(PRESETS["tiny"])), **wrong})


def test_latencies_follow_the_configuration():
    tiny = cluster_timing(PRESETS["tiny"])
    faster = cluster_timing(PRESETS["tiny"].replace({"icu.product_registers": Icu().product_registers - 1}))
    assert faster.setup < tiny.setup
    assert faster.pipeline < tiny.pipeline
    assert faster.traversal < tiny.traversal
