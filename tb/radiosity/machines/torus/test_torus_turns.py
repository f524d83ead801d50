"""Buffers of links are finite: nodes block, go on when a message has been taken, and a deadlock is named."""

import pytest

from golden.base.errors import InputError
from radiosity.machines.torus import torus_state as ts
from radiosity.machines.torus.columns import Item, Node, Tally
from tb.radiosity.machines.torus.torus_cases import run_small

pytestmark = pytest.mark.usefixtures("interpreted")


def test_nodes_block_while_a_buffer_is_full_and_go_on():
    """The largest buffer has the times of one that suffices, and no memory for more than is on its link."""
    small, large, largest = (run_small(nodes=4, size=(40, 40), delay=400_000, buffer=buffer)
                             for buffer in (1024, 1 << 16, 1 << 30))
    assert small.sums.tobytes() == large.sums.tobytes()
    assert small.time > large.time
    assert largest.report() == large.report()


def test_a_deadlock_of_small_buffers_is_named():
    """Nodes whose buffers are full block each other: the source avoids that by few rays alone."""
    with pytest.raises(InputError, match="Buffer must be larger than 340 bytes: the nodes are in a deadlock"):
        run_small(nodes=4, size=(40, 40), delay=400_000, buffer=340)


def test_a_packet_is_sent_when_it_has_21_values():
    tallies = run_small(nodes=4, size=(24, 20)).state.tallies
    values, packets = tallies[:, Tally.VALUES], tallies[:, Tally.PACKETS]
    assert (packets == -(-values // 21)).all()
    # Packets of 20 or 22 values would be other numbers.
    assert all((packets != -(-values // other)).any() for other in (20, 22))


def test_shadow_rays_wait_apart_from_other_rays(monkeypatch):
    """Those that arrive, too: nodes trace them first."""
    push, seen = ts.push_first, set()

    def note(state, node, queue, item):
        seen.add((queue, int(state.items[item, Item.KIND])))
        push(state, node, queue, item)

    monkeypatch.setattr(ts, "push_first", note)
    assert run_small.__wrapped__(nodes=4).state.tallies[:, Tally.PASSED].sum() > 0
    assert seen == {(Node.RAYS, ts.RAY), (Node.SHADOWS, ts.SHADOW)}
