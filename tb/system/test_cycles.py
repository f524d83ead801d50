"""A fixed set of frusta takes the cycles that it took: neither more nor fewer."""

import json

import pytest

from tb.system.cycles import BASELINE, FRUSTA, cycles_of
from tb.system.small_machine import ONE_CLUSTER

# What a frustum may take more or less; where that is meant, `python -m tb.system.cycles` writes the baseline anew.
SHARE = 0.02


@ONE_CLUSTER
@pytest.mark.parametrize("name", FRUSTA)
def test_cycles_stay(name):
    expected = json.loads(BASELINE.read_text())[name]
    found = cycles_of(name)
    assert len(found) == len(expected)
    for now, before in zip(found, expected, strict=True):
        assert abs(now - before) <= SHARE * before, (
            f"{name}: {found} cycles instead of {expected}; if that is meant: python -m tb.system.cycles")
