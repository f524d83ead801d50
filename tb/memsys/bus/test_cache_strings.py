"""What clusters request in castings: the hardware's cache answers each request as golden's does."""

import pytest

from benchmarks.caches import cast_strings
from benchmarks.ceiling import SCENES
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS
from hw.memsys.bus.cache_policy import CachePolicy
from tb.lib.drawn import drawn
from tb.memsys.cache_replay import replay

POLICIES = [policy.name for policy in CachePolicy]


def strings(name, hemisphere, cell, most):
    """The first requests of each."""
    _, _, joined = cast_strings(name, PRESETS["paper"], 2, (3, 12), hemisphere=hemisphere, cell=cell)
    return {what: string[:most] for what, string in joined.items()}


@pytest.mark.sim
def test_a_few_castings():
    came = replay(strings("lobby", Hemisphere(64, 16), 0.125, 250), POLICIES, lines=16, simulator="verilator")
    for what, by_policy in came.items():
        assert set(by_policy) == set(POLICIES), what
        # Else nothing would have distinguished the policies.
        assert len({found["misses"] for found in by_policy.values()}) > 1, what


@pytest.mark.nightly
@pytest.mark.parametrize("lines", drawn([8, 64, 256]))
def test_five_scenes(lines):
    given = {f"{name}: {what}": string for name in SCENES
             for what, string in strings(name, Hemisphere(256, 64), 0.0625, 5000).items()}
    came = replay(given, POLICIES, lines=lines)
    assert all(set(by_policy) == set(POLICIES) for by_policy in came.values()), "names of policies"
