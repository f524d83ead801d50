"""Ten million drawn rays on engines of one, two and four clusters: every field of every hit, and every sum."""

import os
import random
import sys

import pytest

from tb.system.ray_campaign import cast_campaign

RAYS = 10_000_000
# Campaigns of each number of clusters, and the rays of each one.
PARTS, SHARE = {1: 4, 2: 4, 4: 2}, 1_000_000
CASES = [(clusters, part) for clusters, parts in PARTS.items() for part in range(parts)]
# Another one every night.
SEED = int(os.environ.get("SEED") or random.SystemRandom().getrandbits(30))


def test_the_campaigns_have_ten_million_rays():
    assert len(CASES) * SHARE >= RAYS


@pytest.mark.nightly
@pytest.mark.parametrize(("clusters", "part"), CASES)
def test_no_ray_differs(clusters, part, capsys):
    seed = SEED + part
    done = cast_campaign(clusters, seed=seed, rays=SHARE)
    with capsys.disabled():
        sys.stdout.write(f"\n{clusters} clusters, seed {seed}: {done.rays} rays, {len(done.differences)} differences, "
                         f"{dict(done.found)}, {done.cycles} cycles\n")
    assert done.rays >= SHARE
    assert done.found["hits"] > done.rays // 10
    assert done.found["screens"]
    assert done.found["hemispheres"]
    assert not done.differences, (f"{len(done.differences)} differences, the first in {done.differences[0]}: "
                                  f"python -m tb.system.ray_campaign --clusters {clusters} --seed {seed}")
