import numpy as np

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
