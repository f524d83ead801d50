"""Pixels of regions are sent and merged: what is counted is what travels, and no winner is lost."""

import numpy as np
import pytest

from radiosity.machines.merge.exchange_steps import mesh_steps
from radiosity.machines.merge.pixel_exchange import MET, SENT, TOUCHED, exchange, received_by_owners, scattered
from radiosity.machines.merge.winning_pixels import Pixels

pytestmark = pytest.mark.usefixtures("interpreted")

NODES, CELLS = 8, 64
BOUNDS = np.arange(0, CELLS + 1, CELLS // NODES)


def drawn(seed, share=0.4):
    """Pixels with few depths and shades, so that many are equal."""
    rng = np.random.default_rng(seed)
    held = [np.flatnonzero(rng.random(CELLS) < share) for _ in range(NODES)]
    count = sum(map(len, held))
    return Pixels(np.append(0, np.cumsum(list(map(len, held)))), np.concatenate(held),
                  rng.integers(0, 3, count).astype(float), rng.integers(0, 3, count).astype(np.uint32))


def least(pixels):
    """By location the least depth, and of these the least shade."""
    best = {}
    for location, *rank in zip(*pixels[1:], strict=True):
        best[location] = min(best.get(location, rank), rank)
    return sorted((location, *rank) for location, rank in best.items())


@pytest.mark.parametrize("sides", [(8,), (4, 2), (2, 4), (2, 2, 2)])
@pytest.mark.parametrize("seed", range(3))
def test_winners_remain_and_are_in_the_node_of_their_region(sides, seed):
    pixels, steps = drawn(seed), mesh_steps(sides)
    before = pixels
    for step in range(len(steps.target)):
        held = pixels
        pixels, counts = exchange(pixels, steps, step, BOUNDS)
        first, last = BOUNDS[steps.first[step]], BOUNDS[steps.last[step]]
        for node in range(NODES):
            source = steps.source[step, node]
            own, sent, came = (held.location[held.start[who]:held.start[who + 1]] for who in (node, node, source))
            sent = sent[(sent >= first[node]) & (sent < last[node])]
            came = came[(came >= first[source]) & (came < last[source])]
            own = own[(own >= first[source]) & (own < last[source])]
            assert counts[node, SENT] == len(sent)
            assert counts[node, TOUCHED] == len(own) + len(came)
            assert counts[node, MET] == len(np.intersect1d(own, came))
        assert least(pixels) == least(before)
    assert len(pixels.location) == len(least(before))
    for node in range(NODES):
        own = pixels.location[pixels.start[node]:pixels.start[node + 1]]
        assert (own // (CELLS // NODES) == steps.region[node]).all()
        assert (np.diff(own) > 0).all()


@pytest.mark.parametrize("seed", range(3))
def test_owners_have_the_winners_after_an_exchange_from_each_to_all(seed):
    pixels = drawn(seed)
    done = scattered(pixels, BOUNDS)
    assert sorted(zip(*done[1:], strict=True)) == least(pixels)
    assert np.array_equal(done.start, np.searchsorted(done.location, BOUNDS))


def test_pixels_are_counted_by_owner():
    pixels = drawn(1)
    counts = received_by_owners(pixels, BOUNDS)
    node = np.repeat(np.arange(NODES), np.diff(pixels.start))
    expected = np.zeros((NODES, NODES), dtype=np.int64)
    np.add.at(expected, (node, pixels.location // (CELLS // NODES)), 1)
    assert np.array_equal(counts, expected)
