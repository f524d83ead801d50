"""The profile 1987 has the source's times, and a node's time is the sum of what its rays and messages take."""

import pytest

from radiosity.machines.torus.columns import Tally
from radiosity.machines.torus.ray_timing import PROFILES, RayTiming
from tb.radiosity.machines.torus.torus_cases import run_small

pytestmark = pytest.mark.usefixtures("interpreted")


def test_the_profile_has_the_times_of_tables_4_3_and_4_4():
    timing = PROFILES["1987"]
    assert (timing.array_step, timing.array_setup, timing.hash_step, timing.hash_setup) == (59, 684, 90, 807)
    assert (timing.sphere_test, timing.sphere_hit, timing.polygon_test, timing.polygon_hit) == (218, 1301, 320, 1362)
    assert (timing.call, timing.rest) == (2000, 6000)


@pytest.mark.parametrize("storage", ["array", "hash"])
def test_busy_times_are_those_of_walks_rays_and_calls(storage):
    run = run_small(nodes=4, storage=storage)
    timing, tallies = RayTiming(), run.state.tallies
    setup, step = ((timing.array_setup, timing.array_step) if storage == "array"
                   else (timing.hash_setup, timing.hash_step))
    costs = (step, timing.sphere_test, timing.polygon_test, timing.sphere_hit, timing.polygon_hit)
    expected = (tallies[:, Tally.TRACED].sum() * setup + run.rays * timing.rest
                + tallies[:, Tally.CALLS].sum() * timing.call
                + sum(run.walked(column) * cost for column, cost in enumerate(costs)))
    # Node 0 takes each object from the host with a call that is not in the tally of calls.
    expected += len(run.scene) * timing.call
    assert run.state.busy.sum() == expected


def test_negative_times_are_refused():
    with pytest.raises(ValueError, match="Rest must be at least 0, not -1"):
        RayTiming(rest=-1)
