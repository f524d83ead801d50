"""Rows are made under each scheme; when a memory is full, nodes keep their own patches alone, and these travel."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.common.assignment import assign
from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.gather.node_memory import PATCH_WORDS, NodeMemory
from radiosity.machines.gather.row_phase import SCHEMES, GatherScheme, make_matrix_rows
from tb.radiosity.machines.gather.nodes import drawn_work

pytestmark = pytest.mark.usefixtures("interpreted")

PATCHES, ENTRIES = 45, np.full(45, 9)
ROW = NodeMemory.row_bytes(9)


def run(scheme, *, nodes=8, memory=None, **options):
    work = drawn_work(3, PATCHES)
    cube = hypercube(nodes, work.timing)
    return make_matrix_rows(GatherScheme(name=scheme, **options), ENTRIES, work, cube, memory or NodeMemory()), cube


def full(rows):
    """A memory for all patches and so many rows."""
    return NodeMemory(size=NodeMemory().size - NodeMemory().free(PATCHES) + rows * ROW)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("memory", [None, full(3)], ids=["large", "small"])
@pytest.mark.parametrize("nodes", [1, 2, 8])
def test_each_row_is_made_once(scheme, memory, nodes):
    if memory and nodes < 8:
        memory = NodeMemory(size=memory.size + PATCHES // nodes * ROW)
    found, _ = run(scheme, nodes=nodes, memory=memory)
    assert np.array_equal(np.sort(found.assignment.order), np.arange(PATCHES))
    assert found.assignment.nodes == nodes
    assert 0 < found.efficiency <= 1
    assert found.time == found.ends.max() > 0


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("memory", [None, full(3)], ids=["large", "small"])
def test_a_node_stores_its_rows_one_after_the_other_until_it_ends(scheme, memory):
    found, _ = run(scheme, memory=memory)
    for node in range(8):
        times = found.stored[found.assignment.patches(node)]
        assert times[0] > 0
        # A row takes the time of its projections at least; one that is projected block by block, that of its messages.
        assert (np.diff(times) >= found.alone[found.assignment.patches(node)[1:]]).all()
        assert times[-1] <= found.ends[node]


def test_static_schemes_keep_their_assignment():
    for scheme in ("circulation", "sharing"):
        for kind in ("random", "scattered", "tiled"):
            found, _ = run(scheme, assignment=kind, seed=4, memory=full(3))
            expected = assign(kind, PATCHES, 8, seed=4)
            assert np.array_equal(found.assignment.order, expected.order)
            assert np.array_equal(found.assignment.bounds, expected.bounds)


def test_shared_storage_takes_messages_for_the_maximum_alone_until_it_is_full():
    found, cube = run("sharing")
    assert (cube.sent[:8] == 3).all()
    assert (found.before_full, found.circulated_words) == (PATCHES, 0)


def test_one_full_memory_has_all_nodes_circulate_for_the_most_rows_that_are_left():
    entries = ENTRIES.copy()
    held = assign("tiled", PATCHES, 8)
    entries[held.patches(5)[1]] = 60
    memory = NodeMemory(size=full(6).size + 8)
    work = drawn_work(3, PATCHES)
    cube = hypercube(8, work.timing)
    found = make_matrix_rows(GatherScheme(name="sharing", assignment="tiled"), entries, work, cube, memory)
    assert 8 < found.before_full < PATCHES
    stored = found.before_full
    rounds, left = divmod(found.circulated_words, 7 * PATCHES * PATCH_WORDS)
    assert left == 0
    # Node 5 stored one of its rows, and the most that any node lacks are those.
    assert rounds == len(held.patches(5)) - 1 >= (PATCHES - stored) // 8
    assert cube.sent[:8, MESSAGES].sum() == 8 * 3 + 7 + rounds * 7 * 8


def test_the_replica_is_freed_for_the_rest_of_the_rows():
    found, _ = run("sharing", memory=full(4))
    assert found.before_full == 8 * 4
    own = PATCHES - 6 - 6
    assert found.peak_bytes.max() == max(full(4).size, full(6).size - own * 4 * PATCH_WORDS)


@pytest.mark.parametrize("nodes", [1, 2, 8])
def test_nodes_have_memory_for_their_rows_their_patches_and_the_largest_block(nodes):
    """The block that travels is another one in each step; a node alone has none. A byte less is refused."""
    found, _ = run("circulation", nodes=nodes)
    held, block = found.assignment.sizes, -(-PATCHES // nodes) if nodes > 1 else 0
    without = NodeMemory().size - NodeMemory().free(0)
    assert found.peak_bytes.tolist() == (without + 4 * PATCH_WORDS * (held + block) + ROW * held).tolist()
    least = found.peak_bytes.max()
    assert run("circulation", nodes=nodes, memory=NodeMemory(size=int(least)))[0].peak_bytes.max() == least
    with pytest.raises(InputError, match=f"Memory must be at least {least} bytes"):
        run("circulation", nodes=nodes, memory=NodeMemory(size=int(least) - 1))


def test_circulation_sends_all_blocks_in_each_round():
    found, cube = run("circulation", assignment="scattered")
    assert found.before_full == 0
    assert found.circulated_words == cube.sent[:, WORDS].sum() == 6 * 7 * PATCHES * PATCH_WORDS


def test_the_host_deals_what_is_left_when_a_memory_is_full():
    found, _ = run("demand-driven", memory=full(2), granularity=3)
    assert found.before_full == 16
    assert found.assignment.sizes.tolist() == [2 + 4] * 5 + [2 + 3] * 3
    tails = [found.assignment.patches(node)[2:] for node in range(8)]
    left = np.sort(np.concatenate(tails))
    assert all(tail.tolist() == left[node::8].tolist() for node, tail in enumerate(tails))
    assert found.circulated_words == 4 * 7 * PATCHES * PATCH_WORDS


def test_demanded_rows_are_balanced_better_than_dealt_ones():
    demanded, dealt = (run(scheme)[0] for scheme in ("demand-driven", "sharing"))
    assert demanded.before_full == dealt.before_full == PATCHES
    assert np.ptp(demanded.ends) < np.ptp(dealt.ends) + 8 * drawn_work(3, 1).timing.setup


@pytest.mark.parametrize("scheme", SCHEMES)
def test_rows_that_never_fit_are_refused(scheme):
    with pytest.raises(InputError, match=r"Memory must be at least \d+ bytes for the patches and rows of node"):
        run(scheme, nodes=1, memory=full(3))


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"name": "bidding"}, InputError, "Scheme must be one of circulation, sharing, demand-driven, not 'bidding'"),
    ({"assignment": "even"}, InputError, "Assignment must be one of random, scattered, tiled, not 'even'"),
    ({"granularity": 0}, InputError, "Granularity must be at least 1, not 0"),
    ({"granularity": 1.5}, TypeError, "Granularity must be an int, not 1.5"),
    ({"seed": -1}, InputError, "Seed must be at least 0, not -1")])
def test_wrong_schemes_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        GatherScheme(**wrong)
