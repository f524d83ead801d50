"""The control of jobs beside its golden model, cycle by cycle, and what holds of every queue."""

import random
from collections import Counter
from dataclasses import replace
from itertools import pairwise

import pytest

from golden.config import PRESETS
from hw.control.job_control import JobControl
from tb.control.job_trace import WRITE_FAULTS, Plan, TraceBench, trace
from tb.lib.coverage import Coverage
from tb.lib.timing import documented_latency

NODES = (1, 2, 3, 4)
CONFIGS = {nodes: PRESETS["tiny"].replace({"noc.columns": nodes, "noc.rows": 1}) for nodes in NODES}
EVENTS = ("stop", "timeout", "network", "unwritten", "far")


@pytest.fixture(scope="module")
def benches():
    return {nodes: TraceBench(config) for nodes, config in CONFIGS.items()}


def check(benches, plan):
    """The hardware says what the model does, in every cycle; the trace and the units around it."""
    found, around = trace(plan)
    came = benches[plan.nodes].run(seen for seen, _ in found)
    for cycle, ((seen, expected), one) in enumerate(zip(found, came, strict=True)):
        # Without a section there is no tag; the number of a record without a fault has no meaning.
        if expected.tag is None:
            one = replace(one, tag=None)
        if expected.load and one.load:
            load = expected.load
            assert one.load == {"image": load.image, "regions": one.load["regions"], "copies": load.copies}
            assert one.load["regions"] & load.regions == load.regions
            one = replace(one, load=expected.load)
        assert one == expected, f"cycle {cycle}, in which the control sees {seen}"
    return found, around


def complete(around):
    """Each descriptor that was taken has exactly one record."""
    assert Counter(around.completed) == Counter(around.taken)


@pytest.mark.parametrize("nodes", NODES)
@pytest.mark.parametrize("seed", range(2))
def test_a_queue_without_faults(benches, nodes, seed):
    kinds = ("load", *("section",) * 9, "refused", "section", "load", *("section",) * 6)
    found, around = check(benches, Plan(nodes=nodes, seed=seed, cycles=700, kinds=kinds, ring_bits=2 * seed))
    complete(around)
    assert len(around.taken) == len(kinds) == found[-1][1].taken
    assert not any(found[-1][1].status[name] for name in ("busy", "halted", "failed"))


@pytest.mark.parametrize("event", EVENTS)
@pytest.mark.parametrize("nodes", [
    pytest.param(nodes, marks=[] if nodes in (2, 3) else pytest.mark.nightly) for nodes in NODES])
def test_an_event_at_any_time(benches, nodes, event):
    """Stops and faults with 0 to 3 sections of a cluster in flight, in a load, and while idle."""
    coverage = Coverage(["in a load", "idle", "resumed with copies", "resumed without copies",
                         *(f"{count} in flight" for count in range(4))])
    kinds = ("load", *("section",) * 9, "load", *("section",) * 3)
    is_thorough = (nodes, event) == (2, "stop")
    for cycle in range(3, 220, 9 if is_thorough else 43):
        plan = Plan(nodes=nodes, seed=cycle, cycles=cycle + 330, kinds=kinds, events={cycle: event}, ring_bits=4,
                    busiest=3)
        found, around = check(benches, plan)
        complete(around)
        seen = found[cycle][1]
        coverage.hit("in a load", seen.status["loading"])
        coverage.hit("idle", not seen.status["busy"])
        resumes = {said.load.copies for given, said in found if said.load and said.load.image == given.registers.image}
        coverage.hit("resumed with copies", True in resumes)
        coverage.hit("resumed without copies", False in resumes)
        for count in range(4):
            coverage.hit(f"{count} in flight", count in in_flight(found, cycle, nodes))
        assert any(said.status["halted"] for _, said in found[cycle:])
        assert found[-1][1].taken == len(kinds), "the queue goes on"
    if is_thorough:
        coverage.check()


def in_flight(found, cycle, nodes):
    """How many sections each cluster has, by what has been sent and collected since the last reset."""
    counts = [0] * nodes
    for seen, said in found[:cycle]:
        if said.stops or said.status["halted"]:
            counts = [0] * nodes
            continue
        if seen.sent:
            counts[seen.sent[0]] += 1
        if seen.collected is not None:
            counts[seen.collected] -= 1
    return counts


def test_the_culprit_has_its_own_code(benches):
    """All others are aborted, and each code occurs."""
    codes = Counter()
    for seed in range(16):
        event = ("timeout", "network")[seed % 2]
        found, around = check(benches, Plan(seed=seed, cycles=500, events={60 + seed: event}, slowest=40))
        codes.update(record.code for record in around.records)
        blamed = [record for record in around.records if record.code not in ("NONE", "ABORTED")]
        assert len(blamed) <= 1
        error = next(said.error for _, said in found if said.error)
        assert all((record.code, record.cluster) == (error.code, error.cluster) for record in blamed)
    assert set(codes) == {"NONE", "ABORTED", "PATH_TIMEOUT", "NETWORK_ORDER"}


@pytest.mark.parametrize("nodes", [1, 3])
def test_of_faults_at_once_that_of_the_cluster_comes_first(benches, nodes):
    """`error` and the record of the culprit have the same one."""
    blamed = []
    for seed in range(4):
        plan = Plan(nodes=nodes, seed=seed, cycles=200, events={60 + seed: "timeout network"}, slowest=40)
        found, around = check(benches, plan)
        assert next(said.error.code for _, said in found if said.error) == "PATH_TIMEOUT"
        blamed += {record.code for record in around.records} - {"NONE", "ABORTED"}
    assert set(blamed) == {"PATH_TIMEOUT"}


def test_a_doorbell_too_far_is_no_error_of_a_queue_that_stops(benches):
    """In the cycle of the stop: it is noticed a cycle later, when the queue does not run any more."""
    found, _ = check(benches, Plan(cycles=90, events={60: "stop far"}, resumes=False))
    assert found[61][1].stops
    assert not any(said.error for _, said in found)


def test_the_culprit_after_a_stop(benches):
    """Sections that had not begun when they were aborted change nothing of who is blamed later."""
    codes, both = Counter(), False
    for seed in range(8):
        event = ("timeout", "network")[seed % 2]
        found, around = check(benches, Plan(seed=seed, nodes=1 + seed % 2, cycles=260, slowest=30, events={
            50 + 3 * seed: "stop", 160 + seed: event}))
        codes.update(record.code for record in around.records)
        both |= sum(said.stops and not before.stops for (_, before), (_, said) in pairwise(found)) == 2
    assert both
    assert codes["PATH_TIMEOUT"]
    assert codes["NETWORK_ORDER"]


@pytest.mark.parametrize("nodes", NODES)
def test_the_watchdog(benches, nodes):
    """Of sections and of loads."""
    codes = Counter()
    for seed in range(3):
        plan = Plan(nodes=nodes, seed=seed, cycles=600, watchdog=30 + seed, slowest=24, bad_loads=0)
        found, around = check(benches, plan)
        codes.update((record.code, record.cluster == 0xFF) for record in around.records)
        if not found[-1][1].status["busy"]:
            complete(around)
    assert codes["WATCHDOG", False]
    plan = Plan(nodes=nodes, cycles=300, watchdog=3, slowest=24, kinds=("load",), resumes=False)
    found, around = check(benches, plan)
    assert [(record.code, record.cluster) for record in around.records] == [("WATCHDOG", 0xFF)]
    assert found[-1][1].status["halted"]


def test_a_section_may_take_as_many_cycles_as_the_watchdog_allows(benches):
    """One cluster, one section: its record is collected some cycles after it was sent."""
    for limit in range(8, 40, 9):
        for seed in range(4):
            plan = Plan(nodes=1, seed=seed, cycles=120, watchdog=limit, kinds=("section",), slowest=20, resumes=False)
            found, _ = check(benches, plan)
            sent = next(cycle for cycle, (seen, _) in enumerate(found) if seen.sent)
            ended = next((cycle for cycle, (seen, _) in enumerate(found) if seen.collected is not None), None)
            late = any(said.error.code == "WATCHDOG" for _, said in found)
            # The table, the poll that restarts the count, and the comparison take a cycle each.
            assert late == (ended is None or ended - sent >= limit + 2)
            stopped = next((cycle for cycle, (_, said) in enumerate(found) if said.stops), None)
            assert stopped == (sent + limit + 4 if late else None)


@pytest.mark.parametrize("bad", [1, 2])
def test_a_load_that_fails(benches, bad):
    """Of a descriptor it ends in its record; of a resume the queue stays halted."""
    plan = Plan(cycles=500, kinds=("load", "load", "section", "load", "section"), bad_loads=bad)
    found, around = check(benches, plan)
    assert [record.code for record in around.records][:2] == ["READ_REPLY", "POINTER" if bad > 1 else "NONE"]
    assert not any(said.status["halted"] for _, said in found)
    found, around = check(benches, Plan(cycles=500, bad_loads=bad + 1, kinds=("load", *("section",) * 3), events={
        60: "stop", 61: "port reads"}))
    complete(around)
    failures = [said.error.code for _, said in found if said.error]
    assert ("POINTER" in failures) == (bad >= 1)
    assert found[-1][1].taken == 4
    assert not found[-1][1].status["halted"]


def test_a_ring_that_cannot_be_read(benches):
    """What is in flight ends, then the queue is halted; the same descriptor is read again after a resume."""
    for seed in range(2):
        kinds = ("load", "section", "section", "section", "unread", "section")
        events = {5: "port reads"} if seed % 2 else {}
        found, around = check(benches, Plan(cycles=500, seed=seed, kinds=kinds, events=events))
        complete(around)
        assert all(record.code == "NONE" for record in around.records)
        errors = {said.error for _, said in found if said.error}
        assert {(one.code, one.number) for one in errors} == {
            ("READ_OUTSIDE" if seed % 2 and found[20][0].memory else "READ_REPLY", 0x1000 + 4 * 192)}
        assert found[-1][1].taken == len(kinds)


def test_records_that_cannot_be_written(benches):
    """Those that were collected are kept, and the others aborted; a resume writes all of them."""
    for cycle in range(20, 200, 45):
        found, around = check(benches, Plan(cycles=cycle + 450, seed=cycle, events={
            cycle: "unwritten", cycle + 40: "unwritten"}))
        complete(around)
        assert any(said.error.code == "WRITE_REPLY" for _, said in found)
        assert found[-1][1].taken == 13


@pytest.mark.parametrize("seed", range(len(WRITE_FAULTS)))
def test_a_record_that_cannot_be_written_has_the_code_of_the_port(benches, seed):
    found, _ = check(benches, Plan(cycles=60, seed=seed, events={38: "port writes", 40: "unwritten"}))
    assert WRITE_FAULTS[seed] in {said.error.code for _, said in found if said.error}


def test_commands_that_are_not_possible(benches):
    for event in "resume", "none":
        found, _ = check(benches, Plan(cycles=300, events={100: event, 110: "clear", 120: "interrupt"}))
        assert found[101][1].error.code == "COMMAND"
        assert not found[111][1].error
        assert not any(said.status["halted"] for _, said in found), "the queue goes on"


def test_the_interrupt(benches):
    """It is pending when a record has been written and when the queue halts, until a 1 is written."""
    coverage = Coverage(["set by a record", "set by a halt", "cleared", "cleared and set at once", "enabled"])
    for seed in range(3):
        draw = random.Random(seed)
        events = {draw.randrange(400): "interrupt" for _ in range(80)} | {200: "stop"}
        found, _ = check(benches, Plan(seed=seed, cycles=500, events=events))
        for (before, _), (seen, said), (_, after) in zip(found, found[1:], found[2:], strict=False):
            advances = seen.completed != before.completed
            clears = seen.interrupt is not None and seen.interrupt & 2
            coverage.hit("set by a record", advances and after.pending and not said.pending)
            coverage.hit("set by a halt", said.stops and after.pending and not said.pending)
            coverage.hit("cleared", said.pending and not after.pending)
            coverage.hit("cleared and set at once", bool(clears and advances))
            coverage.hit("enabled", after.enabled)
            if advances:
                assert after.pending
    coverage.check()


def test_registers_of_the_ring_stay_while_anything_is_in_flight(benches):
    found, _ = check(benches, Plan(cycles=500, events={150: "stop"}))
    coverage = Coverage(["idle", "halted"])
    for seen, said in found:
        if said.takes:
            assert not seen.memory_busy
            coverage.hit("halted" if said.status["halted"] else "idle")
            assert said.status["halted"] or said.taken == seen.registers.doorbell
    coverage.check()


@pytest.mark.parametrize("nodes", NODES)
def test_everything_at_random(benches, nodes):
    """Several events, loads that fail, descriptors of all kinds, with and without a watchdog."""
    for seed in range(4):
        draw = random.Random(100 * nodes + seed)
        events = {draw.randrange(5, 500): draw.choice((*EVENTS, "clear", "none", "interrupt", "local", "port reads",
                                                      "port writes", "resume")) for _ in range(8)}
        kinds = ("load", *draw.choices(("section", "section", "section", "refused", "load", "unread"), k=25))
        found, around = check(benches, Plan(
            nodes=nodes, seed=seed, cycles=900, kinds=kinds, events=events, ring_bits=draw.randrange(5),
            watchdog=draw.choice((0, 0, 70, 120)), bad_loads=draw.randrange(3), busiest=draw.choice((0, 6, 30))))
        if not found[-1][1].status["busy"]:
            complete(around)


def test_latency():
    assert documented_latency(JobControl, CONFIGS[2]) == JobControl.latency == 1
