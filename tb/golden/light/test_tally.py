from concurrent.futures import ThreadPoolExecutor

import numpy as np

from golden.base.spread import in_turn
from golden.cast.rays import Hits, Rays
from golden.light.tally import Tally


class Half:
    """Every second ray hits; 3 tests and 2 steps a ray."""

    def nearest(self, rays):
        count = len(rays)
        patch = np.where(np.arange(count) % 2, -1, 0)
        return Hits(patch=patch, t=np.ones(count), u=np.zeros(count), v=np.zeros(count),
                    tests=np.full(count, 3), steps=np.full(count, 2))

    any_hit = nearest


def rays(count):
    return Rays(np.zeros((count, 3)), np.ones((count, 3)))


def test_rays_are_counted_by_kind():
    tally = Tally()
    shadow, primary = tally.counting("shadow", Half()), tally.counting("primary", Half())
    shadow.any_hit(rays(4))
    shadow.nearest(rays(6))
    primary.nearest(rays(2))
    assert tally.kinds == {"shadow": {"rays": 10, "hits": 5, "tests": 30, "steps": 20},
                           "primary": {"rays": 2, "hits": 1, "tests": 6, "steps": 4}}


def test_casters_of_one_kind_share_one_account():
    tally = Tally()
    for _ in range(2):
        tally.counting("shadow", Half()).nearest(rays(3))
    assert tally.kinds["shadow"]["rays"] == 6


def test_spread_work_adds_its_rays_to_those_before_it():
    """Also where the work is done by this process, whose tally it then counts in."""
    tally = Tally()
    shadow, primary = tally.counting("shadow", Half()), tally.counting("primary", Half())
    shadow.any_hit(rays(6))

    def work(first, last):
        return len(primary.nearest(rays(last - first)).patch)

    spread = tally.over(in_turn)
    assert dict(spread(work, [(0, 2), (2, 6)])) == {(0, 2): 2, (2, 6): 4}
    assert dict(spread(work, [(6, 8)])) == {(6, 8): 2}
    assert tally.kinds == {"shadow": {"rays": 6, "hits": 3, "tests": 18, "steps": 12},
                           "primary": {"rays": 8, "hits": 4, "tests": 24, "steps": 16}}


def test_hits_pass_through_unchanged():
    hits = Tally().counting("primary", Half()).nearest(rays(3))
    assert hits.patch.tolist() == [0, -1, 0]


def test_the_time_of_a_stage_adds_up():
    tally = Tally()
    with tally.stage("solver"):
        sum(range(1000))
    first = tally.seconds["solver"]
    with tally.stage("solver"):
        sum(range(1000))
    assert tally.seconds["solver"] > first > 0


def test_threads_lose_no_count():
    tally = Tally()
    caster, few = tally.counting("primary", Half()), rays(2)
    with ThreadPoolExecutor(8) as threads:
        list(threads.map(caster.nearest, [few] * 4000))
    assert tally.kinds["primary"] == {"rays": 8000, "hits": 4000, "tests": 24000, "steps": 16000}
