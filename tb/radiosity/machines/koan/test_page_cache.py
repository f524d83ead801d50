"""The page that is dropped is the one least recently used, and none that is being written."""

from collections import OrderedDict
from itertools import pairwise

import pytest

from radiosity.machines.koan.page_state import DROPPED, NONE, READ, USED, WRITE
from tb.radiosity.machines.koan.programs import drawn_run


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("frames", [1, 2, 5, 9])
def test_victims_are_an_oracle_s(frames, seed):
    nodes = 4
    found = drawn_run(seed, nodes=nodes, pages=24, frames=frames, writes=0)
    for node in range(nodes):
        held, victims = OrderedDict(), []
        for page in found.page[node * 250:(node + 1) * 250].tolist():
            if page % nodes == node:
                continue
            if page not in held and len(held) == frames:
                victims.append(held.popitem(last=False)[0])
            held[page] = True
            held.move_to_end(page)
        assert [page for _, who, page, code in found.log if who == node and code == DROPPED] == victims
        assert found.counts["drops"][node] == len(victims)


@pytest.mark.parametrize("seed", range(6))
def test_with_writes_too_the_victim_is_the_oldest_page_that_is_not_written(seed):
    nodes = 4
    found = drawn_run(seed, nodes=nodes, pages=16, frames=3)
    held = [OrderedDict() for _ in range(nodes)]
    for _, node, page, code in found.log:
        if code == USED:
            page = int(found.page[page])
            if page in held[node]:
                held[node].move_to_end(page)
        elif page % nodes == node:
            continue
        elif code in (READ, WRITE):
            held[node][page] = code
        else:
            if code == DROPPED:
                assert page == next(one for one, mode in held[node].items() if mode == READ)
            held[node].pop(page, NONE)
    assert found.counts["drops"].sum() > 0


def test_faults_do_not_increase_with_the_cache():
    faults = [drawn_run(3, pages=24, frames=frames, writes=0).counts["faults"] for frames in range(1, 19)]
    assert all((more >= fewer).all() for more, fewer in pairwise(faults))
    assert faults[0].sum() > 2 * faults[-1].sum()
