"""The merge of vertices, the bus and its interface, and the readers' share of a port, each alone."""

import re
from itertools import pairwise

import pytest
from amaranth.sim import Simulator
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from hw.lib.payload import pack
from hw.memsys.bus.local_bus import LocalBus
from hw.memsys.patches.local_bus_interface import LocalBusInterface
from hw.memsys.patches.patch_merge import PatchMerge
from hw.memsys.patches.path_formats import BEATS, RequestKind
from hw.memsys.patches.vertex_merge import VertexMerge
from hw.memsys.port.read_share import ReadShare
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, schedules
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"memsys.reply_ids": 2, "memsys.bus_requests": 2})
FEW = settings(SETTINGS, max_examples=15)


def vertex(patch, index):
    return {"patch": patch, "surface": patch + 3, "vertex": [patch, index, 7]}


def patch(number):
    return [vertex(number, index) for index in range(4)]


MERGE = ScheduleBench(VertexMerge(config=CONFIG, count=3, patches=2), [f"i__{k}" for k in range(3)], ["o"])
PATCHES = ScheduleBench(PatchMerge(config=CONFIG, count=3), [f"i__{k}" for k in range(3)], ["o"])
GAP = st.sampled_from((0, 0, 0, 1, 3))
# A source may be silent between its patches for longer than those of all others take.
PATCH_GAPS = st.tuples(st.sampled_from((0, 0, 3, 20)), GAP, GAP, GAP)
SOURCES = {f"i__{k}": st.lists(PATCH_GAPS, max_size=4) for k in range(3)}


@pytest.mark.parametrize("bench", [MERGE, PATCHES], ids=["VertexMerge", "PatchMerge"])
@FEW
@given(gaps=st.fixed_dictionaries(SOURCES), stalls=st.lists(GAP, max_size=20))
def test_patches_stay_whole_and_in_the_order_of_their_source(bench, gaps, stalls):
    items = {name: [(gap, vertex(16 * int(name[-1]) + number, index)) for number, four in enumerate(patches)
                    for index, gap in enumerate(four)] for name, patches in gaps.items()}
    came = bench.run(Schedule(items=items, stalls={"o": stalls}))["o"]
    four = [came[k:k + 4] for k in range(0, len(came), 4)]
    assert all(group == patch(group[0]["patch"]) for group in four)
    for k in range(3):
        assert [group[0]["patch"] for group in four if group[0]["patch"] // 16 == k] == [
            16 * k + number for number in range(len(gaps[f"i__{k}"]))]


@pytest.mark.parametrize("bench", [MERGE, PATCHES], ids=["VertexMerge", "PatchMerge"])
@pytest.mark.parametrize("first", range(3))
def test_a_source_that_has_ended_holds_up_no_other(bench, first):
    """The others come when it has nothing more."""
    items = {f"i__{k}": [(20 * (k != first and index == 0), one) for index, one in enumerate(patch(k))]
             for k in range(3)}
    came = bench.run(Schedule(items=items, stalls={"o": []}))["o"]
    assert sorted(one["patch"] for one in came[::4]) == [0, 1, 2]
    assert came[0]["patch"] == first


def test_one_vertex_per_cycle_of_all_sources_and_the_longest_waiting_first():
    items = {f"i__{k}": [(0, one) for number in range(3) for one in patch(16 * k + number)] for k in range(3)}
    came = MERGE.run(Schedule(items=items, stalls={"o": []}))["o"]
    cycles = MERGE.cycles["o"]
    assert {b - a for a, b in pairwise(cycles)} == {1}
    assert cycles[0] - MERGE.cycles["i__0"][3] == documented_latency(VertexMerge, CONFIG)
    assert [one["patch"] for one in came[::4]] == [0, 16, 32, 1, 17, 33, 2, 18, 34]


def test_patches_without_buffers_the_longest_waiting_first():
    """A gap between patches of one source, none between those of others."""
    items = {f"i__{k}": [(0, one) for number in range(3) for one in patch(16 * k + number)] for k in range(3)}
    came = PATCHES.run(Schedule(items=items, stalls={"o": []}))["o"]
    cycles = PATCHES.cycles["o"]
    assert cycles == list(range(cycles[0], cycles[0] + len(cycles)))
    assert [one["patch"] for one in came[::4]] == [0, 16, 32, 1, 17, 33, 2, 18, 34]
    PATCHES.run(Schedule(items={"i__0": items["i__0"], "i__1": [], "i__2": []}, stalls={"o": []}))
    cycles = PATCHES.cycles["o"]
    assert {b - a for a, b in pairwise(cycles[::4])} == {5}
    assert PATCHES.cycles["i__0"] == cycles
    # The first vertex is offered in cycle 1.
    assert cycles[0] - 1 == documented_latency(PatchMerge, CONFIG)


BUS = LocalBus(config=CONFIG.replace({"noc.columns": 3}), clusters=3)
BUS_BENCH = ScheduleBench(BUS, [*(f"i_request__{k}" for k in range(3)), "i_reply__0", "i_reply__1"],
                          ["o_request", *(f"o_reply__{k}" for k in range(3))])


def test_the_bus_takes_one_request_per_cycle_the_longest_waiting_first():
    requested = [(0, {"kind": RequestKind.PATCH.value, "key": key}) for key in range(4)]
    came = BUS_BENCH.run(Schedule(items={f"i_request__{k}": requested for k in range(3)}, stalls={}))["o_request"]
    assert [one["source"] for one in came] == [0, 1, 2] * 4
    assert [one["item"]["key"] for one in came] == [key for key in range(4) for _ in range(3)]
    cycles = BUS_BENCH.cycles["o_request"]
    assert cycles == list(range(cycles[0], cycles[0] + 12))
    assert cycles[0] - BUS_BENCH.cycles["i_request__0"][0] == documented_latency(LocalBus, CONFIG)


def test_beats_go_to_their_cluster_and_those_of_a_kind_stay_in_order():
    beats = {f"i_reply__{kind}": [(0, {"cluster": number % 3, "kind": kind, "last": number % 2, "data": number})
                                  for number in range(9)] for kind in range(2)}
    came = BUS_BENCH.run(Schedule(items=beats, stalls={}))
    for cluster in range(3):
        for kind in range(2):
            data = [one["data"] for one in came[f"o_reply__{cluster}"] if one["kind"] == kind]
            assert data == [number for number in range(9) if number % 3 == cluster]


INTERFACE = LocalBusInterface(config=CONFIG)
FORMATS = INTERFACE._formats


def cell_beat(number, *, is_id=1, more=0, last=0, error=0):
    data = pack(FORMATS.cell_beat, {"number": number, "is_id": is_id, "more": more})
    return {"kind": RequestKind.CELL.value, "last": last, "error": error, "data": data}


def patch_beats(number, error=0):
    head = pack(FORMATS.patch_head, {"patch": number, "surface": number + 3})
    bits = CONFIG.numbers.scene.width
    beats = [head, *(sum(part << bits * axis for axis, part in enumerate(one["vertex"])) for one in patch(number))]
    return [{"kind": RequestKind.PATCH.value, "last": k == BEATS - 1, "error": error, "hit": number % 2, "data": data}
            for k, data in enumerate(beats)]


INTERFACE_BENCH = ScheduleBench(INTERFACE, ["i_cell", "i_patch", "i_reply"], ["o_request", "o_listed", "o_vertex"],
                                idle_limit=60)


def wait(cycles, items):
    """The first item after some cycles, the others at once."""
    return [(cycles if k == 0 else 0, item) for k, item in enumerate(items)]


@FEW
@given(st.lists(GAP, max_size=30), st.lists(GAP, max_size=12), st.lists(GAP, max_size=30))
def test_the_interface_requests_parts_and_forwards_replies(requests, listed, vertices):
    """Cell 4 has three entries, in two parts; cell 9 has none; the reply of patch 6 is an error."""
    replies = [*wait(70, [cell_beat(11), cell_beat(12, more=1, last=1), *patch_beats(5)]),
               *wait(0, [cell_beat(0, is_id=0, last=1), *patch_beats(6, error=1)]),
               *wait(250, [cell_beat(13, last=1)])]
    came = INTERFACE_BENCH.run(
        Schedule(items={"i_cell": [(0, 4), (0, 9)], "i_patch": [(0, 5), (0, 6)], "i_reply": replies},
                 stalls={"o_request": requests, "o_listed": listed, "o_vertex": vertices}))
    requested = [(one["kind"], one["key"]) for one in came["o_request"]]
    cells = [key for kind, key in requested if kind == RequestKind.CELL.value]
    assert cells == [4, 9, 4 | 1 << FORMATS.cell_bits]
    assert [key for kind, key in requested if kind == RequestKind.PATCH.value] == [5, 6]
    entries = [(one["item"]["number"], one["last"]) for one in came["o_listed"] if one["item"]["is_id"]]
    assert entries == [(11, 0), (12, 0), (13, 1)]
    assert [one["last"] for one in came["o_listed"]] == [0, 0, 1, 1]
    assert came["o_vertex"] == patch(5)


def lost_of(replies, *, holds=0):
    """What the interface says to be lost, cycle by cycle, of replies after requests for patches and cells 6, 5 and 9;
    vertices are not accepted in the first cycles.
    """
    dut, lost = LocalBusInterface(config=CONFIG.replace({"memsys.bus_requests": 4})), []

    async def bench(ctx):
        for out in dut.o_request, dut.o_listed:
            ctx.set(out.ready, 1)
        for requests in dut.i_cell, dut.i_patch:
            for number in 6, 5, 9:
                ctx.set(requests.valid, 1)
                ctx.set(requests.payload, number)
                await ctx.tick().until(requests.ready)
            ctx.set(requests.valid, 0)
        await ctx.tick().repeat(5)
        for cycle, beat in enumerate([*replies, *[None] * 12]):
            ctx.set(dut.o_vertex.ready, cycle >= holds)
            ctx.set(dut.i_reply.valid, beat is not None)
            if beat:
                ctx.set(dut.i_reply.payload, beat)
            await ctx.tick()
            lost.append({(name, ctx.get(getattr(dut, name))) for name in ("cell", "patch")
                         if ctx.get(getattr(dut, f"lost_{name}"))})

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return [one for one in lost if one]


@pytest.mark.parametrize("kind", ["cell", "patch"])
def test_a_lost_reply_is_reported_once_with_its_number(kind):
    """It has as many entries, or vertices, as a good one; the one behind it is good."""
    replies = [beat for number, error in ((6, 1), (5, 0)) for beat in (
        [cell_beat(11, error=error), cell_beat(12, error=error, last=1)] if kind == "cell"
        else patch_beats(number, error))]
    assert lost_of(replies) == [{(kind, 6)}]


def test_a_cell_and_a_patch_that_are_lost_together_have_a_number_each():
    """The patch waits behind a good one, so that it is lost before the cell, with it, and after it."""
    replies = [*patch_beats(6), *patch_beats(5, error=1), cell_beat(0, is_id=0, last=1, error=1)]
    found = [lost_of(replies, holds=holds) for holds in range(3, 9)]
    cell, patch = ("cell", 6), ("patch", 5)
    assert [{patch}, {cell}] in found
    assert [{cell, patch}] in found
    assert [{cell}, {patch}] in found
    assert all(one in ([{patch}, {cell}], [{cell, patch}], [{cell}, {patch}]) for one in found)


def test_no_more_requests_than_reserved_entries():
    items = {"i_cell": [(0, number) for number in range(2)], "i_patch": [(0, number) for number in range(2)]}
    INTERFACE_BENCH.run(Schedule(items=items, stalls={}))
    assert len(INTERFACE_BENCH.cycles["o_request"]) == 4
    first = {name: cycles[0] for name, cycles in INTERFACE_BENCH.cycles.items() if cycles}
    assert first["o_request"] - first["i_cell"] == documented_latency(LocalBusInterface, CONFIG)
    with pytest.raises(AssertionError, match="items were never accepted"):
        INTERFACE_BENCH.run(Schedule(items={**items, "i_cell": [(0, number) for number in range(3)]}, stalls={}))


SHARE = ScheduleBench(ReadShare(config=CONFIG, count=3), [*(f"i_request__{k}" for k in range(3)), "i_reply"],
                      ["o_request", *(f"o_reply__{k}" for k in range(3))])
REQUESTS = st.lists(st.tuples(GAP, st.fixed_dictionaries({
    "address": st.integers(0, 99), "length": st.integers(0, 3)})), max_size=5)


@FEW
@given(schedules({"i_reply": st.fixed_dictionaries({"data": st.integers(0, 99), "tag": st.integers(0, 2)})},
                 [f"o_reply__{k}" for k in range(3)]), st.lists(REQUESTS, min_size=3, max_size=3))
def test_requests_carry_their_reader_and_replies_find_it(schedule, requests):
    items = {**schedule.items, **{f"i_request__{k}": given for k, given in enumerate(requests)}}
    came = SHARE.run(Schedule(items=items, stalls=schedule.stalls))
    for k, given_ in enumerate(requests):
        assert [(one["address"], one["length"]) for one in came["o_request"] if one["tag"] == k] == [
            (one["address"], one["length"]) for _, one in given_]
        assert [one["data"] for one in came[f"o_reply__{k}"]] == [
            one["data"] for one in schedule.values("i_reply") if one["tag"] == k]


@pytest.mark.parametrize(("make", "message"), [
    (lambda: VertexMerge(config=CONFIG, count=0), "Count must be at least 1, not 0"),
    (lambda: VertexMerge(config=CONFIG, count=1, patches=1), "Patches must be at least 2, not 1"),
    (lambda: LocalBus(config=CONFIG, clusters=3), "Clusters must be from 1 to 2, not 3"),
    (lambda: ReadShare(config=CONFIG, count=0), "Count must be at least 1, not 0")])
def test_init_wrong(make, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        make()
