"""Rows of the scaling of the engine."""

from types import SimpleNamespace

import pytest

from benchmarks.scaling import row_of

pytestmark = pytest.mark.xdist_group("machines")

BOUNDS = dict.fromkeys(("load", "casts", "longest section", "dispatch", "port"), 10)


def run(nodes, rays, cycles):
    return SimpleNamespace(nodes=nodes, groups=nodes, rays=rays, cycles=cycles, bounds=BOUNDS, bound="casts",
                           efficiency=0.5, is_extrapolated=False)


@pytest.mark.parametrize(("nodes", "rays", "cycles", "rate", "speedup"), [
    (1, 1000, 4000, "0.250", "1.00"),
    # Strong scaling: the same rays in fewer cycles.
    (4, 1000, 1250, "0.800", "3.20"),
    # Weak scaling: more rays, in as many cycles and in more.
    (4, 4000, 4000, "1.000", "4.00"), (16, 16000, 5000, "3.200", "12.80")])
def test_the_speedup_is_that_of_rays_per_cycle(nodes, rays, cycles, rate, speedup):
    assert row_of(run(nodes, rays, cycles), run(1, 1000, 4000))[-2:] == [rate, speedup]
