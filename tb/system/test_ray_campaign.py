"""A million drawn rays a night on engines of one, two and four clusters: every field of every hit, and every sum."""

import sys

import pytest

from tb.lib.seed import NIGHTS, SEED
from tb.system.ray_campaign import cast_campaign

# Rays of each number of clusters in a night.
SHARE = 350_000


@pytest.mark.nightly
@pytest.mark.parametrize("clusters", [1, 2, 4])
@pytest.mark.parametrize("part", range(NIGHTS))
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
