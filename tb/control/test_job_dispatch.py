import random
from itertools import pairwise

import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator

from golden.engine.config import PRESETS
from golden.engine.jobs.completion import NO_CLUSTER
from golden.engine.jobs.descriptor import ANY_CLUSTER, RULES, check_descriptor
from hw.control.job_dispatch import JobDispatch
from hw.control.job_formats import DESCRIPTOR_WORDS, NEAR_INDEX, JobFormats, byte_of
from hw.lib.payload import pack, unpack
from hw.registers.error_code import ErrorCode
from tb.control.job_descriptors import changed, descriptor, near_words, words_of
from tb.lib.timing import documented_latency

CLUSTERS = 3
CONFIG = PRESETS["tiny"].replace({"noc.columns": CLUSTERS, "noc.rows": 1})
SIDE = 1 << CONFIG.icu.side_bits
# Numbers that do not fit all formats of results.
WIDE = CONFIG.replace({"icu.uv_bits": 9, "icu.patch_bits": 23})
# With shadow frusta.
SHADOW, BITS = CONFIG.replace({"icu.shadow_bits": 4}), {"bundle": 2, "hit_format": 0, "sums": 0}


class Dispatch:
    """A dispatch between a fetch and clusters, each with a slot that takes its time."""

    def __init__(self, config=CONFIG):
        self.config, self._dut = config, JobDispatch(config=config)
        self._simulator, self._given = Simulator(self._dut), None
        self._simulator.add_clock(1e-8)

    def run(self, ones, *, seed=0, gaps=0.0, requests=None, loaded=True, last_shell=63, errors=(), cycles=2000,
            enable=lambda cycle: 1, slow=0.0):
        """What happens, as (cycle, event) in order.

        Parameters
        ----------
        ones
            Descriptors; near cells are numbers.
        gaps
            How often no word is offered.
        requests
            From a cycle to the clusters that want a section; default: all, and again some cycles after each section.
        last_shell
            The last shell that has been loaded.
        errors
            Of words: number of the descriptor, and of the word in it and its near cells.
        slow
            How often loads and refusals are not accepted.
        """
        self._given = {"ones": ones, "seed": seed, "gaps": gaps, "requests": requests, "loaded": loaded,
                       "last_shell": last_shell, "errors": set(errors), "cycles": cycles, "enable": enable,
                       "slow": slow}
        if hasattr(self, "found"):
            self._simulator.reset()
        else:
            self._simulator.add_testbench(self._drive)
        self.found, self.waits, self.begun = [], [], []
        self._simulator.run()
        return self.found

    def words(self):
        given = self._given
        for number, one in enumerate(given["ones"]):
            near = near_words(one, self.config)
            data = [*words_of(one), *(number * 1000 + k for k in range(near))]
            for k, word in enumerate(data):
                index = min(k, NEAR_INDEX)
                yield {"index": index, "data": word, "last": int(k == len(data) - 1),
                       "error": int((number, k) in given["errors"])}

    async def _drive(self, ctx):
        dut, given, found = self._dut, self._given, self.found
        draw, words = random.Random(given["seed"]), list(self.words())
        shape = dut.i.payload.shape()
        wanting = dict.fromkeys(range(self.config.noc.clusters), 1)
        ctx.set(dut.loaded, int(given["loaded"]))
        ctx.set(dut.last_shell, given["last_shell"])
        offered = False
        outputs = [dut.i.ready, dut.failed, dut.busy]
        for one in dut.o, dut.o_sent, dut.o_load, dut.o_refused:
            outputs += [one.valid, Value.cast(one.payload)]
        for cycle in range(given["cycles"]):
            offered = bool(words) and (offered or draw.random() >= given["gaps"])
            ctx.set(dut.i.valid, int(offered))
            if offered:
                ctx.set(Value.cast(dut.i.payload), pack(shape, words[0]))
            if given["requests"] is None:
                now = [k for k, when in wanting.items() if when == cycle]
            else:
                now = given["requests"](cycle)
            ctx.set(dut.requests, sum(1 << k for k in now))
            ctx.set(dut.enable, int(given["enable"](cycle)))
            ready = draw.random() >= given["slow"]
            ctx.set(dut.o_load.ready, int(ready))
            ctx.set(dut.o_refused.ready, int(ready))
            seen = (await ctx.tick().sample(*outputs))[2:]
            taken, failed, busy, valid, word, sent, section, load, job, refused, record = seen
            self.waits += [(event, busy) for event, is_so in (("load", load), ("refused", refused), ("failed", failed))
                           if is_so and not (event != "failed" and ready)]
            if offered and taken:
                if words.pop(0)["index"] == 0:
                    self.begun.append(cycle)
                offered = False
            if valid:
                found.append((cycle, "word", unpack(dut.o.payload.shape(), word)))
            if sent:
                section = unpack(dut.o_sent.payload.shape(), section)
                found.append((cycle, "sent", section))
                wanting[section["cluster"]] = cycle + draw.randint(2, 40)
            if load and ready:
                found.append((cycle, "load", unpack(dut.o_load.payload.shape(), job)))
            if refused and ready:
                found.append((cycle, "refused", unpack(dut.o_refused.payload.shape(), record)))
            if failed and not (found and found[-1][1] == "failed"):
                found.append((cycle, "failed", None))
            if not words and found and cycle > found[-1][0] + 60:
                break


@pytest.fixture(scope="module")
def dispatch():
    return Dispatch()


def outcomes(found):
    """Of each descriptor what became of it, with the words that a cluster got."""
    words, reported = [], []
    for _, event, value in found:
        if event == "word":
            words.append(value)
        else:
            reported.append((event, value, words))
            words = []
    return reported


def check(ones, found, *, loaded=True, last_shell=63, config=CONFIG):
    """Each descriptor is sent, refused or loaded as golden's rules say."""
    reported = outcomes(found)
    assert len(reported) == len(ones)
    for number, (one, (event, value, words)) in enumerate(zip(ones, reported, strict=True)):
        refusal = check_descriptor(one, config)
        assert value["tag"] == one["tag"]
        if words:
            expected = [*words_of(one), *(1000 * number + k for k in range(near_words(one, config)))]
            assert [word["data"] for word in words] == expected
            assert [word["index"] for word in words] == [min(k, NEAR_INDEX) for k in range(len(expected))]
            assert [word["last"] for word in words] == [0] * (len(words) - 1) + [1]
            assert [word["void"] for word in words] == [0] * (len(words) - 1) + [int(event != "sent")]
            assert len({word["cluster"] for word in words}) == 1
            assert one["cluster"] in (ANY_CLUSTER, words[0]["cluster"])
        is_missing = one["kind"] == 0 and (not loaded or one["last_shell"] > last_shell)
        if refusal or is_missing:
            code, byte = (refusal.code, refusal.byte) if refusal else ("NOT_LOADED", 52 if loaded else 0)
            assert (event, ErrorCode(value["code"]).name, value["number"]) == ("refused", code, byte)
            assert value["cluster"] == NO_CLUSTER
        elif one["kind"] == 1:
            assert (event, words) == ("load", [])
            assert (value["image"], value["regions"]) == (int(one["hits"]), int(one["regions"]) & REGIONS)
            assert value["copies"] == (one["cluster"] == 0)
        else:
            assert event == "sent"
            assert value["cluster"] == words[0]["cluster"]
    return reported


WHOLE = {"first_column": 0, "first_row": 0}
REGIONS = (1 << JobFormats(CONFIG).load_job["regions"].shape) - 1
TILES = CONFIG.icu.rays >> 2 * CONFIG.icu.tile_bits
TILE = 1 << CONFIG.icu.tile_bits
# Changes of a good descriptor: each limit, one below and one above it.
LIMITS = [
    *({"version": value} for value in (0, 1, 2, 257)), *({"kind": value} for value in (0, 1, 2, 255)),
    *({"hit_format": value} for value in (0, 3, 4, 255)), *({"sums": value} for value in (0, 1, 2)),
    *({"context": value} for value in (1, 128)),
    *({"cluster": value} for value in (0, CLUSTERS - 1, CLUSTERS, ANY_CLUSTER - 1, ANY_CLUSTER)),
    *({name: value} for name in ("hits", "sums_address") for value in (
        0, 32, 63, 64, (1 << 40) - 64, 1 << 40, (1 << 64) - 64)),
    *({"near_cells": value} for value in (4, 8, (1 << 40) - 8, 1 << 40)),
    *({"near_count": value} for value in (0, 1, 2, (1 << 9) - 1, 1 << 9, (1 << 9) + 1, 1 << 31)),
    *({"last_shell": value} for value in (0, 1, 63, 64, 1 << 31)), *({"reserved": value} for value in (1, 1 << 31)),
    *({"ray_count": value} for value in (1, 1 << 31)), *({"bundle": value} for value in (0, 1, 2, 1 << 31)),
    *({"columns": value, "end_column": 1} for value in (SIDE, SIDE + 1, 1 << 31)),
    *({"rows": value, "end_row": 1} for value in (SIDE, SIDE + 1)),
    *({**WHOLE, "end_column": end, "columns": 12, "end_row": 1} for end in (0, 1, 12, 13)),
    *({**WHOLE, "end_row": end, "rows": 12, "end_column": 1} for end in (0, 1, 12, 13)),
    *({**WHOLE, "first_column": first, "end_column": 8, "columns": 12} for first in (7, 8, 9)),
    *({**WHOLE, "first_row": first, "end_row": 8, "rows": 12} for first in (7, 8, 9)),
    *({**WHOLE, "end_column": SIDE + more, "columns": SIDE, "end_row": 1} for more in (-1, 0, 1)),
    # In a frustum as large, the section is the first field that breaks a rule.
    *({"first_column": SIDE - 1, "end_column": SIDE + more, "columns": SIDE + more, "first_row": 0, "end_row": 1}
      for more in (0, 1)),
    *({"first_row": SIDE - 1, "end_row": SIDE + more, "rows": SIDE + more, "first_column": 0, "end_column": 1}
      for more in (0, 1)),
    # Tiles of the whole ray memory, and a row or a column more; unfinished tiles count.
    *({**WHOLE, "end_column": 16 * TILE + more, "columns": SIDE, "end_row": TILES // 16 * TILE + below, "rows": SIDE}
      for more in (-1, 0, 1) for below in (-1, 0, 1)),
    # As many columns and rows as there are numbers for.
    *({**WHOLE, "end_column": SIDE, "columns": SIDE, "end_row": end, "rows": SIDE}
      for end in (TILES * TILE * TILE // SIDE, TILES * TILE * TILE // SIDE + 1, SIDE)),
    {"kind": 1, "hit_format": 9, "sums": 9, "near_cells": 1, "near_count": 1 << 20, "last_shell": 0, "end_column": 0},
    {"kind": 1, "hits": 32}, {"kind": 1, "context": 1}, {"kind": 1, "reserved": 2},
    *({"kind": 1, "cluster": value} for value in (0, 1, CLUSTERS - 1, CLUSTERS, 77, ANY_CLUSTER - 1, ANY_CLUSTER)),
    {"kind": 1, "hits": 1 << 40}, {"version": 7, "kind": 9}, {"sums": 2, "reserved": 1}, {"kind": 9, "reserved": 1}]


def test_every_rule_at_its_limit(dispatch):
    draw, broken = random.Random(1), set()
    ones = [changed(descriptor(CONFIG, draw), **change) for change in LIMITS]
    for begin in range(0, len(ones), 30):
        part = ones[begin:begin + 30]
        check(part, dispatch.run(part, cycles=6000, seed=begin))
    for one in ones:
        refusal = check_descriptor(one, CONFIG)
        broken |= {refusal and refusal.reason}
    broken |= {check_descriptor(one, WIDE).reason for one in results(draw) if check_descriptor(one, WIDE)}
    broken |= {check_descriptor(one, SHADOW).reason for one in lists(draw) if check_descriptor(one, SHADOW)}
    assert broken == {None, *(rule.about for rule in RULES)}


def lists(draw):
    """A descriptor at each limit of lists of rays."""
    return [changed(descriptor(SHADOW, draw), **change) for change in (
        *({**BITS, "bundle": value} for value in (1, 2, 3)),
        *({**BITS, "hit_format": hits, "sums": sums} for hits in range(4) for sums in range(2)),
        *({**BITS, "ray_count": value} for value in (1, 16, 17, 1 << 31)),
        {"bundle": 0, "ray_count": 1}, {"bundle": 1, "ray_count": 16}, {**BITS, "near_count": 0, "ray_count": 3})]


def test_lists_of_rays_at_their_limits():
    ones = lists(random.Random(6))
    check(ones, Dispatch(SHADOW).run(ones, cycles=3000), config=SHADOW)


def results(draw):
    """A descriptor for each form of results."""
    return [changed(descriptor(CONFIG, draw), hit_format=hits, sums=sums) for hits in range(4) for sums in range(2)]


@pytest.mark.parametrize("config", [WIDE, CONFIG.replace({"icu.patch_bits": 23}), CONFIG.replace({"icu.uv_bits": 9})],
                         ids=["both", "patches", "positions"])
def test_results_that_the_machine_cannot_represent_are_refused(config):
    ones, refusals = results(random.Random(5)), []
    for one in ones:
        refusal = check_descriptor(one, config)
        refusals += [(ErrorCode[refusal.code].value, refusal.byte)] if refusal else []
    found = Dispatch(config).run(ones)
    assert [(value["code"], value["number"]) for _, event, value in found if event == "refused"] == refusals
    assert 0 < len(refusals) < len(ones)


@pytest.mark.parametrize(("gaps", "slow"), [
    (0.1, 0.7), *(pytest.param(*one, marks=pytest.mark.sim) for one in ((0, 0), (0.5, 0)))])
def test_sections_loads_and_refusals(dispatch, gaps, slow):
    for seed in range(3):
        draw = random.Random(seed)
        ones = [changed(descriptor(CONFIG, draw), **draw.choice((
            {}, {}, {}, {"cluster": 0}, {"cluster": 2}, {"kind": 1}, {"kind": 1, "cluster": 0},
            {"version": 3}, {"last_shell": 0})))
                for _ in range(20)]
        check(ones, dispatch.run(ones, seed=seed, gaps=gaps, slow=slow, cycles=9000))


def test_no_descriptor_begins_without_enable(dispatch):
    """One that has begun ends, whatever it is; its first word is taken a cycle after it begins."""
    draw = random.Random(17)
    changes = ({}, {"kind": 1}, {"sums": 3}, {}, {"kind": 2}, {"kind": 1, "hits": 1}, {}, {"kind": 1}, {})

    def enable(cycle):
        return cycle % 97 < 40

    ones = [changed(descriptor(CONFIG, draw), **change) for change in changes]
    check(ones, dispatch.run(ones, gaps=0.1, slow=0.5, enable=enable))
    assert len(dispatch.begun) == len(ones)
    assert all(enable(cycle - 1) for cycle in dispatch.begun)


def test_nothing_is_cast_before_a_load(dispatch):
    draw = random.Random(7)
    changes = ({}, {"sums": 3}, {"kind": 1}, {"kind": 1, "hits": 1})
    ones = [changed(descriptor(CONFIG, draw), **change) for change in changes]
    reported = check(ones, dispatch.run(ones, loaded=False), loaded=False)
    assert not any(words for *_, words in reported)


@pytest.mark.parametrize("last_shell", [1, 7, 62])
def test_a_section_beyond_the_loaded_shells_is_refused(dispatch, last_shell):
    draw = random.Random(last_shell)
    shells = (last_shell, last_shell + 1, 63, last_shell, 1)
    ones = [descriptor(CONFIG, draw, last_shell=one) for one in shells]
    # A load is none, and another rule comes first.
    ones += [changed(ones[1], kind=1), changed(ones[1], reserved=1), ones[0]]
    reported = check(ones, dispatch.run(ones, last_shell=last_shell), last_shell=last_shell)
    assert [event for event, *_ in reported] == [
        "sent", "refused", "refused", "sent", "sent", "load", "refused", "sent"]
    assert all(words[-1]["void"] for event, _, words in reported if event == "refused")
    (unloaded,) = check(ones[1:2], dispatch.run(ones[1:2], loaded=False, last_shell=last_shell), loaded=False)
    assert unloaded[1]["number"] == 0


def test_one_section_for_each_want(dispatch):
    """A cluster gets no section that it does not want; a refused one leaves it wanting."""
    draw = random.Random(2)
    ones = [descriptor(CONFIG, draw) for _ in range(4)]
    ones.insert(1, changed(ones[0], last_shell=0))
    found = dispatch.run(ones, requests=lambda cycle: {5: [1], 300: [1], 600: [0], 601: [2]}.get(cycle, []))
    reported = check(ones, found)
    assert [(event, words[0]["cluster"]) for event, _, words in reported] == [
        ("sent", 1), ("refused", 1), ("sent", 1), ("sent", 0), ("sent", 2)]
    firsts = [cycle for cycle, event, value in found if event == "word" and value["index"] == 0]
    assert firsts[0] < 10
    assert 300 < firsts[1] < 305
    assert 600 < firsts[3] < 640


def test_the_cluster_that_has_waited_longest_is_served(dispatch):
    draw = random.Random(3)
    ones = [descriptor(CONFIG, draw, near_count=0) for _ in range(6)]
    order = {2: [2], 4: [0], 6: [1], 90: [0, 1], 91: [2]}
    found = dispatch.run(ones, requests=lambda cycle: order.get(cycle, []), enable=lambda cycle: cycle > 10)
    assert [value["cluster"] for _, event, value in found if event == "sent"] == [2, 0, 1, 0, 1, 2]


def test_a_pinned_section_waits_for_its_cluster(dispatch):
    draw = random.Random(3)
    ones = [descriptor(CONFIG, draw, cluster=2), descriptor(CONFIG, draw)]
    found = dispatch.run(ones, requests=lambda cycle: {2: [0], 3: [1], 200: [2]}.get(cycle, []))
    sent = [(cycle, value["cluster"]) for cycle, event, value in found if event == "sent"]
    assert [cluster for _, cluster in sent] == [2, 0]
    assert sent[0][0] > 200


def test_it_is_busy_while_a_refusal_waits_but_not_while_a_load_waits_or_after_a_failure(dispatch):
    """A load waits for the sections before it; the queue may end meanwhile."""
    draw = random.Random(4)
    ones = [descriptor(CONFIG, draw, kind=1), descriptor(CONFIG, draw), descriptor(CONFIG, draw, version=3),
            descriptor(CONFIG, draw)] * 3
    dispatch.run(ones, slow=0.8, errors=[(11, 3)], seed=6)
    assert {event for event, _ in dispatch.waits} == {"load", "refused", "failed"}
    assert set(dispatch.waits) == {("load", 0), ("refused", 1), ("failed", 0)}


@pytest.mark.parametrize("index", [0, 3, 23])
def test_a_descriptor_that_could_not_be_read_ends_the_dispatch(dispatch, index):
    draw = random.Random(index)
    ones = [descriptor(CONFIG, draw) for _ in range(3)]
    reported = outcomes(dispatch.run(ones, errors=[(1, index)], cycles=400))
    assert [event for event, *_ in reported] == ["sent", "failed"]
    assert all(word["void"] == word["last"] for word in reported[1][2])
    assert bool(reported[1][2]) == (index > 0)


@pytest.mark.parametrize("which", [(0,), (1,), (2,), (0, 1, 2)])
def test_near_cells_that_could_not_be_read(dispatch, which):
    draw = random.Random(9)
    ones = [descriptor(CONFIG, draw, near_count=5) for _ in range(3)]
    reported = outcomes(dispatch.run(ones, errors=[(1, NEAR_INDEX + cell) for cell in which]))
    assert [event for event, *_ in reported] == ["sent", "refused", "sent"]
    assert (reported[1][1]["code"], reported[1][1]["number"]) == (ErrorCode.READ_REPLY.value, ones[1]["near_cells"])
    assert reported[1][2][-1]["void"]
    # What could not be read counts before what has not been loaded, and before a shell beyond those that have been.
    for given in {"loaded": False}, {"last_shell": 0}:
        reported = outcomes(dispatch.run(ones, errors=[(1, NEAR_INDEX + cell) for cell in which], **given))
        assert [(record["code"], record["number"]) for _, record, _ in reported] == [
            (ErrorCode.READ_REPLY.value, ones[1]["near_cells"]) if k == 1 else
            (ErrorCode.NOT_LOADED.value, byte_of("last_shell") if given.get("loaded", True) else 0) for k in range(3)]


@pytest.mark.parametrize("near", [0, 1, 28])
def test_rate(dispatch, near):
    """24 words, those of near cells, and two cycles; 4 more at most from a want to the section."""
    draw = random.Random(5)
    ones = [descriptor(CONFIG, draw, near_count=near) for _ in range(8)]
    found = dispatch.run(ones, requests=lambda cycle: [cycle % CLUSTERS])
    sent = [cycle for cycle, event, _ in found if event == "sent"]
    words = DESCRIPTOR_WORDS + -(-near // 2)
    assert {after - before for before, after in pairwise(sent)} == {words + 2}
    found = dispatch.run(ones[:1], requests=lambda cycle: [0] if cycle == 50 else [])
    first, last = found[0][0], next(cycle for cycle, event, _ in found if event == "sent")
    assert last - 50 <= words + 4
    # The want is registered.
    assert first - 51 == documented_latency(JobDispatch, CONFIG) == JobDispatch.latency


def test_a_section_of_a_patch_node_is_refused():
    """It has no cluster, so none would ever request the section."""
    config = CONFIG.replace({"noc.patch_nodes": 1})
    draw = random.Random(1)
    ones = [descriptor(config, draw, cluster=node) for node in range(config.noc.nodes)]
    reported = check(ones, Dispatch(config).run(ones), config=config)
    assert [event for event, *_ in reported] == ["sent", "sent", "refused"]


def test_one_cluster():
    config = PRESETS["tiny"].replace({"noc.columns": 1, "noc.rows": 1})
    dispatch, draw = Dispatch(config), random.Random(1)
    ones = [descriptor(config, draw) for _ in range(4)]
    assert [event for event, *_ in outcomes(dispatch.run(ones))] == ["sent"] * 4
