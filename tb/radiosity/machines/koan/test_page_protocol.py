"""Pages are coherent: one copy to write or many to read, and what is read is what was written last."""

import numpy as np
import pytest

from radiosity.machines.koan.page_state import DROPPED, INVALIDATED, READ, USED, WRITE, WRITTEN_BACK
from radiosity.machines.koan.page_timing import PageTiming
from tb.radiosity.machines.koan.programs import QUICK, drawn_run, run_programs

REQUEST_NS = QUICK.trap + QUICK.setup + 1 * QUICK.word
PAGE_NS = QUICK.setup + (1 + 16) * QUICK.word
RUNS = [(4, 10, 3), (8, 6, 1), (16, 20, 2), (2, 5, 2)]
LATER = 10_000_000


def read(page, word=0):
    return page, 0, word, -1


def write(page, value, word=0):
    return page, 1, word, value


@pytest.mark.parametrize("nodes", [1, 2, 8, 16])
def test_readers_of_a_page_fetch_it_once_each_and_invalidate_nothing(nodes):
    found = run_programs([[(0, [read(3)] * 5)]] * nodes, pages=8)
    assert found.counts["fetches"].sum() == nodes - 1
    assert found.counts["fetches"][3 % nodes] == 0
    assert found.counts["invalidations"].sum() == found.counts["drops"].sum() == 0


@pytest.mark.parametrize(("nodes", "page"), [(4, 0), (4, 5), (8, 21)])
def test_the_home_of_a_page_is_its_number_mod_the_nodes(nodes, page):
    found = run_programs([[(0, [read(page)])]] * nodes, pages=24)
    assert np.flatnonzero(found.counts["pages_sent"]).tolist() == [page % nodes]
    assert found.counts["faults"].tolist() == [int(node != page % nodes) for node in range(nodes)]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("nodes", "pages", "frames"), RUNS)
def test_a_page_in_write_mode_is_the_only_copy_and_no_node_gets_a_mode_without_the_page(nodes, pages, frames, seed):
    found, modes, fetched = drawn_run(seed, nodes=nodes, pages=pages, frames=frames), {}, [0] * nodes
    for page in range(pages):
        modes[page] = {page % nodes: READ}
    for _, node, page, code in found.log:
        if code == USED:
            continue
        if code in (READ, WRITE):
            # Homes get their pages back in other messages.
            fetched[node] += node not in modes[page] and node != page % nodes
            modes[page][node] = code
        else:
            del modes[page][node]
        assert len(modes[page]) == 1 or WRITE not in modes[page].values()
    assert found.counts["invalidations"].sum() > 0
    assert found.counts["fetches"].tolist() == fetched


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("nodes", "pages", "frames"), RUNS)
def test_a_load_has_the_value_stored_last(nodes, pages, frames, seed):
    """The references in the order in which they are made are a sequentially consistent execution."""
    found, memory, last = drawn_run(seed, nodes=nodes, pages=pages, frames=frames), {}, [-1] * nodes
    made = [(node, at) for _, node, at, code in found.log if code == USED]
    assert sorted(at for _, at in made) == list(range(len(found.page)))
    for node, at in made:
        assert at > last[node]
        last[node], where = at, (found.page[at], found.word[at])
        if found.is_write[at]:
            memory[where] = found.references.value[at]
        else:
            assert found.references.value[at] == memory.get(where, 0)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("nodes", "pages", "frames"), RUNS)
def test_a_write_sends_an_invalidation_to_each_other_copy_and_gets_as_many_acknowledgements(nodes, pages, frames, seed):
    found, expected = drawn_run(seed, nodes=nodes, pages=pages, frames=frames), 0
    copies = {page: set() for page in range(pages)}
    for _, node, page, code in found.log:
        if code == WRITE:
            copies[page] = {node}
        elif code == READ:
            copies[page].add(node)
        elif code == WRITTEN_BACK:
            copies[page].discard(node)
        elif code == INVALIDATED and node != page % nodes:
            expected += 1
        if code == DROPPED:
            assert node in copies[page]
    dropped = sum(code == DROPPED for *_, code in found.log)
    sent = found.counts["invalidations"].sum()
    # Homes do not know of copies that have been dropped.
    assert expected <= sent <= expected + dropped
    assert found.counts["acknowledgements"].sum() == sent


@pytest.mark.parametrize("readers", [0, 1, 5, 7])
def test_a_writer_invalidates_exactly_the_copies(readers):
    """Node 1 writes page 0 of node 0, which ``readers`` nodes have read."""
    programs = [[], [(LATER, [write(0, 9)])], *([(0, [read(0)])] if number < readers else [] for number in range(6))]
    found = run_programs(programs, pages=8)
    assert found.counts["invalidations"].tolist() == [min(readers, 6), *[0] * 7]
    assert found.counts["acknowledgements"].sum() == min(readers, 6)


def test_a_read_fault_takes_a_request_and_a_page():
    found = run_programs([[(500, [read(1)])], []], pages=2)
    assert found.times.ends[0] == 500 + REQUEST_NS + QUICK.serve + PAGE_NS + QUICK.serve


def test_a_write_waits_for_all_acknowledgements():
    programs = [[], [(LATER, [write(0, 9)])], [(0, [read(0)])], [(0, [read(0)])]]
    found = run_programs(programs, pages=4)
    message = QUICK.setup + QUICK.word
    # Both invalidations are set up before the first arrives; the home handles their answers one after the other.
    waited = 2 * QUICK.setup + QUICK.word + QUICK.serve + message + QUICK.serve
    assert found.times.ends[0] >= LATER + REQUEST_NS + QUICK.serve + waited + PAGE_NS + QUICK.serve
    lost = max(time for time, node, _, code in found.log if code == INVALIDATED and node in (2, 3))
    written = next(time for time, node, _, code in found.log if code == WRITE and node == 1)
    assert written > lost + message


def test_an_owner_that_wrote_writes_on_without_a_message():
    found = run_programs([[(0, [write(1, value) for value in range(6)])], []], pages=2)
    assert found.counts["faults"].sum() == found.counts["fetches"].sum() == 1


def test_a_writer_that_has_a_copy_gets_no_page():
    found = run_programs([[(0, [read(1), write(1, 5)])], []], pages=2)
    assert found.counts["faults"][0] == 2
    assert found.counts["fetches"][0] == 1


def test_a_writer_whose_copy_is_invalidated_while_it_waits_gets_the_page():
    """Nodes 1 and 2 have copies of a page of node 0, and request to write it at once; the first one's value is sent."""
    programs = [[], [(0, [read(0)]), (LATER, [write(0, 5)])],
                [(0, [read(0)]), (LATER, [write(0, 6, word=1)]), (0, [read(0)])], []]
    found = run_programs(programs, pages=4)
    written = [node for _, node, _, code in found.log if code == WRITE]
    assert written == [1, 2]
    assert found.counts["fetches"].tolist() == [0, 1, 2, 0]
    assert found.counts["invalidations"].tolist() == [2, 0, 0, 0]
    assert found.references.value.tolist() == [0, 5, 0, 6, 5]


def test_a_read_of_a_page_being_written_brings_it_home_and_leaves_its_writer_a_copy():
    programs = [[(0, [write(1, 7)]), (3 * LATER, [read(1)])], [], [(LATER, [read(1)])], []]
    found = run_programs(programs, pages=4)
    assert found.counts["recalls"].tolist() == [0, 1, 0, 0]
    assert found.counts["faults"].tolist() == [1, 0, 1, 0]
    assert found.references.value.tolist() == [7, 7, 7]
    assert found.counts["invalidations"].sum() == 0


def test_pages_being_written_are_pinned_and_go_home_if_all_frames_are():
    written = [write(page, page) for page in (1, 3, 5)]
    found = run_programs([[(0, [written[0], written[1], read(7), read(9), written[0]])], []], pages=10, frames=3)
    assert [(page, code) for _, node, page, code in found.log if node == 0 and code in (DROPPED, WRITTEN_BACK)] == [
        (7, DROPPED)]
    found = run_programs([[(0, [*written, read(7), read(1, 0)])], []], pages=10, frames=3)
    assert [(page, code) for _, node, page, code in found.log if node == 0 and code in (DROPPED, WRITTEN_BACK)] == [
        (1, WRITTEN_BACK), (7, DROPPED)]
    assert found.counts["write_backs"].tolist() == [1, 0]
    assert found.references.value[-1] == 1


def test_a_server_interrupts_a_program_for_its_time_and_a_device_does_not():
    programs = [[(LATER, [])], [(0, [read(0)])]]
    served = QUICK.serve + QUICK.setup
    found = run_programs(programs, pages=2)
    assert found.times.ends[0] == LATER + served
    assert found.counts["interrupted"].tolist() == [served, 0]
    offloaded = PageTiming(setup=100, word=1, trap=1000, serve=10_000, is_offloaded=1)
    assert run_programs(programs, pages=2, timing=offloaded).times.ends[0] == LATER


def test_a_reference_to_another_home_takes_the_access_time():
    checked = PageTiming(setup=100, word=1, trap=1000, serve=10_000, access=70)
    found = [run_programs([[(0, [read(0), read(1), read(1)])], []], pages=2, timing=one) for one in (QUICK, checked)]
    assert found[1].times.ends[0] - found[0].times.ends[0] == 2 * 70
