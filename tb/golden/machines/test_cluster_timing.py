"""Numbers of a cluster's timing are checked."""

from dataclasses import asdict

import pytest

from golden.config import PRESETS, Icu
from golden.machines.cluster_timing import ClusterTiming
from radiosity.cluster_timing import cluster_timing

TIMING = cluster_timing(PRESETS["tiny"])


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"setup": -1}, ValueError, "Setup must be at least 0, not -1"),
    ({"cells": 0}, ValueError, "Cells must be at least 1, not 0"),
    ({"walk": 1.5}, TypeError, "Walk must be an int, not 1.5")])
def test_numbers_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        ClusterTiming(**{**asdict(TIMING), **wrong})


def test_latencies_follow_the_configuration():
    faster = cluster_timing(PRESETS["tiny"].replace({"icu.product_registers": Icu().product_registers - 1}))
    assert faster.setup < TIMING.setup
    assert faster.pipeline < TIMING.pipeline
    assert faster.traversal < TIMING.traversal
