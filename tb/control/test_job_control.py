"""The control of jobs by its rules, with units that take their time and events in any cycle; `JobRules` are checked in
each cycle of each run.
"""

import random
from collections import Counter
from itertools import combinations

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.completion import NO_CLUSTER
from hw.control import cluster_watch
from hw.control.job_control import JobControl
from hw.noc.network_fault import NetworkFault
from hw.registers.error_code import ErrorCode
from tb.control.control_bench import ControlBench, Script
from tb.control.job_units import COPIES, IMAGE, RING, JobUnits, Plan
from tb.lib.coverage import Coverage
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.seed import SEED
from tb.lib.timing import documented_latency

NODES = (1, 2, 3, 4)
CONFIGS = {nodes: PRESETS["tiny"].replace({"noc.columns": nodes, "noc.rows": 1}) for nodes in NODES}
EVENTS = ("stop", "timeout", "network", "unwritten", "far")
TIMEOUT = {"code": ErrorCode.PATH_TIMEOUT.value, "number": 77}
READ_ERROR = {"code": ErrorCode.READ_REPLY.value, "address": 0x3000}


@pytest.fixture(scope="module")
def benches():
    return {nodes: ControlBench(config) for nodes, config in CONFIGS.items()}


def play(benches, plan):
    """The inputs and outputs of each cycle, and the units."""
    units = JobUnits(plan)
    return benches[plan.nodes].run(units, plan.cycles), units


def complete(units):
    """Each descriptor that was taken has exactly one record."""
    assert Counter(units.completed) == Counter(units.taken), "jobs of several clusters complete in any order"


def codes(records):
    """Names of the records' codes, in their order."""
    return [ErrorCode(record["code"]).name for record in records]


def records_of(found):
    """The records that have left."""
    return [said["o_record"] for given, said in found if said["o_record"] and given["o_record"]]


def errors(found):
    """Names of the codes of `error`, in their order."""
    seen = [said["error"]["code"] for _, said in found]
    return [ErrorCode(code).name for before, code in zip([0, *seen], seen, strict=False) if code not in (0, before)]


@pytest.mark.parametrize("nodes", NODES)
def test_a_queue_without_faults(benches, nodes):
    kinds = ("load", *("section",) * 6, "refused", "section", "load", "part", *("section",) * 4)
    found, units = play(benches, Plan(nodes=nodes, cycles=900, kinds=kinds, ring_bits=nodes - 1))
    complete(units)
    assert len(units.taken) == len(kinds) == found[-1][1]["taken"]
    assert not any(found[-1][1]["status"][name] for name in ("busy", "halted", "failed"))


@pytest.mark.parametrize("event", [EVENTS[0], *(pytest.param(one, marks=pytest.mark.sim) for one in EVENTS[1:])])
def test_an_event_at_any_time(benches, event):
    """With sections in flight, in a load, and while idle."""
    for cycle in range(3, 180, 53):
        at_any_time(benches, 2 + cycle % 2, event, cycle)


@pytest.mark.nightly
@pytest.mark.parametrize("event", EVENTS)
@pytest.mark.parametrize("nodes", NODES)
def test_an_event_at_many_times(benches, nodes, event):
    """In every state, with 0 to 3 sections of a cluster in flight."""
    coverage = Coverage(["in a load", "idle", "resumed with copies", "resumed without copies",
                         *(f"{count} in flight" for count in range(4))])
    for cycle in range(3, 320, 11):
        found = at_any_time(benches, nodes, event, cycle)
        # A doorbell, wherever it points, is work.
        _, said = found[cycle - 1]
        coverage.hit("in a load", said["status"]["loading"])
        coverage.hit("idle", not said["status"]["busy"])
        resumes = {said["o_load"]["copies"] for _, said in found if said["o_load"] and said["o_load"]["image"] == IMAGE}
        coverage.hit("resumed with copies", 1 in resumes)
        coverage.hit("resumed without copies", 0 in resumes)
        for count in in_flight(found, cycle, nodes):
            coverage.hit(f"{count} in flight")
    assert not coverage.missing


def at_any_time(benches, nodes, event, cycle):
    """A queue of two loads with an event."""
    kinds = ("load", *("section",) * 4 * nodes, "load", *("section",) * 2)
    plan = Plan(nodes=nodes, seed=cycle, cycles=cycle + 200 + 250 * nodes, kinds=kinds, events={cycle: event},
                ring_bits=5, busiest=3, slowest=20 * nodes)
    found, units = play(benches, plan)
    complete(units)
    assert any(said["status"]["halted"] for _, said in found[cycle:])
    assert found[-1][1]["taken"] == len(kinds), "the queue goes on"
    return found


def in_flight(found, cycle, nodes):
    """How many sections each cluster has, by what has been sent and collected since the last reset."""
    counts = [0] * nodes
    for given, said in found[:cycle]:
        if said["stops"] or said["status"]["halted"]:
            counts = [0] * nodes
            continue
        if given["i_sent"]:
            counts[given["i_sent"]["cluster"]] += 1
        if given["i_collected"] is not None:
            counts[given["i_collected"]] -= 1
    return counts


PAIRS = [*combinations((*EVENTS, "resume", "clear"), 2)]


@pytest.mark.parametrize(("number", "count"), [(0, 7), pytest.param(1, 210, marks=pytest.mark.nightly)])
def test_two_events_at_a_drawn_distance(benches, number, count):
    """In the same reset, and after it; each descriptor has a record, and the queue goes on."""
    draw = random.Random(SEED + number)
    for seed, events in enumerate(draw.choices(PAIRS, k=count)):
        first, distance = draw.randrange(10, 120), draw.choice((1, 2, 3, 4, 5, draw.randrange(6, 30)))
        plan = Plan(nodes=draw.choice(NODES), seed=seed, cycles=first + 480, busiest=draw.choice((0, 6)),
                    kinds=("load", *("section",) * 7),
                    events=dict(zip((first, first + distance), draw.sample(events, 2), strict=True)))
        found, units = play(benches, plan)
        complete(units)
        assert found[-1][1]["taken"] == len(plan.kinds), f"the queue goes on: {plan}"


def section(cluster, tag):
    return {"i_sent": {"cluster": cluster, "tag": tag}}


def test_the_first_of_errors_at_once(benches):
    """Of each two errors that become one in the same cycle, `error` is the one that the docstring names first."""
    at, limit, nodes = 31, 20, 2
    # What happens so that the error of each name is there in the cycle ``at``. The clusters are polled in turn: the
    # first one in even cycles.
    sent = at - limit - nodes - 2
    resume = {2: {"i_command": 1}, 9: {"i_command": 4}}
    causes = {
        "WATCHDOG": {0: {"watchdog": limit}, sent: section(0, 5)},
        "WRITE_REPLY": {at: {"unwritten": 1, "address": 0x9040}},
        "POINTER": {**resume, at: {"load_over": {"code": ErrorCode.POINTER.value, "address": 8}}},
        "PATH_TIMEOUT": {at - 2: {"clusters": [TIMEOUT, {}]}},
        "NETWORK_ORDER": {at - 2: {"networks": [NetworkFault.ORDER.value, 0]}},
        "READ_REPLY": {at: {"unread": 1}},
        "RING": {at - 1: {"doorbell": 99}},
        "COMMAND": {at: {"i_command": 0}}}
    # The queue runs, or it waits for the load of a resume.
    apart = [{"POINTER", other} for other in ("READ_REPLY", "RING", "WATCHDOG")]
    tried = 0
    for pair in combinations(causes, 2):
        if set(pair) in apart:
            continue
        events = {}
        for name in pair:
            for cycle, changes in causes[name].items():
                events[cycle] = events.get(cycle, {}) | changes
        found = benches[nodes].run(Script(nodes, events), at + 12)
        assert errors(found[at - 1:])[:1] == [pair[0]], pair
        assert found[at][1]["error"]["code"] == 0
        assert found[at + 1][1]["error"]["code"] == ErrorCode[pair[0]].value, pair
        tried += 1
    assert tried == 25


def test_an_error_in_the_cycle_of_a_clear_comes_after_it(benches):
    found = benches[1].run(Script(1, {5: {"i_command": 0}, 10: {"i_command": 2, "unwritten": 1}}), 16)
    assert errors(found) == ["COMMAND", "WRITE_REPLY"]


def test_the_ring_of_a_record_that_cannot_be_written_may_move(benches):
    """Also if nothing else was in flight."""
    found = benches[1].run(Script(1, {10: {"unwritten": 1, "empty": 0}, 20: {"completions": 0x7000}}), 24)
    assert found[-1][1]["kept"]["completions"] == 0x7000


def test_sections_are_aborted_in_their_order_before_the_load(benches):
    """Cluster by cluster, each in the order in which it got them; one that has been collected is none."""
    given = [(2, 11), (0, 12), (2, 13), (0, 14), (1, 15), (2, 16)]
    events = {2 + k: section(*one) for k, one in enumerate(given)}
    events |= {10: {"i_collected": 2}, 20: {"i_command": 1}, 21: {"o_record": 1}}
    found = benches[3].run(Script(3, events), 40)
    records = [(said["o_record"]["cluster"], said["o_record"]["tag"]) for _, said in found if said["o_record"]]
    assert records == [(0, 12), (0, 14), (1, 15), (2, 13), (2, 16)]
    load = {"tag": 9, "image": 64, "regions": 5, "copies": 1}
    found = benches[3].run(Script(3, {2: {"i_load": load}, 8: {"i_command": 1, "o_record": 1}}), 30)
    assert [(said["o_record"]["cluster"], said["o_record"]["tag"]) for _, said in found if said["o_record"]] == [
        (NO_CLUSTER, 9)]


@pytest.mark.parametrize("code", ["PATH_TIMEOUT", "NETWORK_ORDER"])
def test_the_culprit_is_the_section_that_was_begun_last(benches, code):
    """With one, two and three sections begun of three; without one that has begun all are aborted."""
    faults = {"clusters": [{}, TIMEOUT]} if code == "PATH_TIMEOUT" else {"networks": [0, NetworkFault.ORDER.value]}
    for begun in range(4):
        events = {2 + k: section(1, k) for k in range(3)} | {8 + k: {"begins": 2 * (k < begun)} for k in range(4)}
        found = benches[2].run(Script(2, {**events, 20: faults, 26: {"o_record": 1}}), 50)
        records = records_of(found)
        assert [one["tag"] for one in records] == [0, 1, 2]
        assert codes(records) == [code if k == begun - 1 else "ABORTED" for k in range(3)]


def test_patch_nodes_have_a_network_and_no_sections():
    """A fault there is nobody's, one of a cluster is found at its own turn, the watchdog's steps count all nodes."""
    bench = ControlBench(PRESETS["tiny"].replace({"noc.columns": 4, "noc.rows": 1, "noc.patch_nodes": 2}))
    begun = {2: section(0, 0), 3: section(1, 1), 5: {"begins": 3}, 6: {"begins": 0}, 40: {"o_record": 1}}

    def ends(events):
        found = bench.run(Script(2, begun | events, patch_nodes=2), 60)
        records = records_of(found)
        return errors(found), found[-1][1]["error"]["cluster"], codes(records)

    for node in range(4):
        networks = [NetworkFault.ORDER.value if k == node else NetworkFault.NONE.value for k in range(4)]
        assert ends({20: {"networks": networks}}) == (
            ["NETWORK_ORDER"], node, ["NETWORK_ORDER" if k == node else "ABORTED" for k in range(2)])
        assert ends({20 + node: {"clusters": [{}, TIMEOUT]}}) == (["PATH_TIMEOUT"], 1, ["ABORTED", "PATH_TIMEOUT"])
    # The other cluster goes on.
    assert ends({0: {"watchdog": 20}, 12: {"i_collected": 0}})[::2] == (["WATCHDOG"], ["WATCHDOG"])


def test_the_culprit_of_one_reset_is_none_of_the_next(benches):
    """Also if it had no section that could be blamed."""
    events = {2: section(0, 1), 10: {"clusters": [TIMEOUT, {}], "o_record": 1}, 14: {"clusters": [{}, {}]},
              24: {"i_command": 4}, 30: {"load_over": {}}, 34: section(0, 2), 36: {"begins": 1}, 37: {"begins": 0},
              40: {"i_command": 1}}
    found = benches[2].run(Script(2, events), 50)
    records = records_of(found)
    assert [(one["tag"], *codes([one])) for one in records] == [(1, "ABORTED"), (2, "ABORTED")]


def test_a_load_that_has_ended_is_not_aborted(benches):
    """Its record says how it ended, and when."""
    load = {"tag": 9, "image": 64, "regions": 5, "copies": 1}
    events = {2: {"i_load": load}, 8: {"load_over": READ_ERROR}, 12: {"i_command": 1}, 20: {"o_record": 1}}
    found = benches[2].run(Script(2, events), 30)
    (record,) = records_of(found)
    assert (record["tag"], *codes([record]), record["begin"], record["end"]) == (9, "READ_REPLY", 2, 8)


def test_what_comes_in_a_reset_is_ignored(benches):
    """The end of a load, in its first cycle and in a later one."""
    for cycle in 9, 10:
        load = {"tag": 9, "image": 64, "regions": 5, "copies": 1}
        events = {2: {"i_load": load}, 8: {"i_command": 1, "memory_busy": 1}, cycle: {"load_over": {}},
                  12: {"memory_busy": 0}, 16: {"o_record": 1}}
        found = benches[2].run(Script(2, events), 24)
        assert codes(records_of(found)) == ["ABORTED"]


@pytest.mark.parametrize(("cycle", "expected"), [(20, ["READ_REPLY"]), (21, []), (22, [])])
def test_the_load_of_a_resume_fails_until_a_stop_resets_its_unit(benches, cycle, expected):
    """The command is given in cycle 20, and resets in the next one."""
    events = {2: {"i_command": 1}, 10: {"i_command": 4}, 20: {"i_command": 1}}
    events[cycle] = events.get(cycle, {}) | {"load_over": READ_ERROR}
    assert errors(benches[2].run(Script(2, events), 30)) == expected


def test_the_culprit_after_a_stop(benches):
    """Sections that had not begun when they were aborted change nothing of who is blamed later."""
    events = {2: section(0, 1), 3: section(0, 2), 5: {"begins": 1}, 6: {"begins": 0, "o_record": 1},
              10: {"i_command": 1}, 20: {"i_command": 4}, 26: {"load_over": {}}, 30: section(0, 3), 31: section(0, 4),
              33: {"begins": 1}, 34: {"begins": 0}, 40: {"clusters": [TIMEOUT, {}]}}
    found = benches[2].run(Script(2, events), 60)
    records = records_of(found)
    assert [one["tag"] for one in records] == [1, 2, 3, 4]
    assert codes(records) == ["ABORTED", "ABORTED", "PATH_TIMEOUT", "ABORTED"]


def test_a_doorbell_too_far_is_no_error_of_a_queue_that_stops(benches):
    """In the cycle of the stop: it is noticed a cycle later, when the queue does not run any more."""
    found, _ = play(benches, Plan(cycles=90, events={60: "stop far"}, resumes=False))
    assert found[61][1]["stops"]
    assert not errors(found)


@pytest.mark.parametrize("bits", [0, 3, 31])
def test_a_doorbell_may_be_a_ring_ahead(benches, bits):
    """Exactly, and not by one more."""
    for ahead, expected in ((1 << bits, []), ((1 << bits) + 1, ["RING"])):
        found = benches[1].run(Script(1, {0: {"ring_bits": bits}, 6: {"doorbell": ahead}}, submitted=0), 20)
        assert errors(found) == expected


def test_the_number_of_descriptors_wraps():
    """`doorbell` and `taken` count modulo 2^32, and so does the entry of the ring that cannot be read."""
    first = (1 << 32) - 3
    bench, kinds = ControlBench(CONFIGS[2], taken=first), ("load", *("section",) * 4, "unread", "section", "section")
    for event in "stop", "far":
        plan = Plan(nodes=2, cycles=600, first=first, kinds=kinds, events={90: event})
        units = JobUnits(plan)
        found = bench.run(units, plan.cycles)
        complete(units)
        assert found[-1][1]["taken"] == len(kinds) - 3
        # An error is seen in every cycle from its first one on.
        assert set(errors(found)) == {"READ_REPLY", *(("RING",) if event == "far" else ())}


@pytest.mark.parametrize("nodes", NODES)
def test_the_watchdog(benches, nodes):
    """Of sections and of loads."""
    _, units = play(benches, Plan(nodes=nodes, seed=nodes, cycles=200, watchdog=30, slowest=40))
    assert "WATCHDOG" in codes([one for one in units.records if one["cluster"] < nodes])
    found, units = play(benches, Plan(nodes=nodes, cycles=60, watchdog=3, slowest=24, kinds=("load",), resumes=False))
    assert [(codes([record]), record["cluster"]) for record in units.records] == [(["WATCHDOG"], NO_CLUSTER)]
    assert found[-1][1]["status"]["halted"]


@pytest.mark.parametrize("nodes", NODES)
def test_every_watchdog_ends_a_section(nodes, monkeypatch):
    """The last ones too, here of few bits: ages stop at their end."""
    monkeypatch.setattr(cluster_watch, "_COUNT_BITS", 4)
    bench = ScheduleBench(cluster_watch.ClusterWatch(config=CONFIGS[nodes]), idle_limit=16 + 3 * nodes,
                          watched=["culprit"])
    for limit in range(1, 16):
        bench.run(Schedule(items={}), live=1, waits=1, watchdog=limit)
        late = next(cycle for cycle, culprit in enumerate(bench.history["culprit"]) if culprit)
        assert limit <= late <= limit + 3 * nodes


def test_a_section_may_take_as_many_cycles_as_the_watchdog_allows(benches):
    """One cluster: a section's own cycles, from its dispatch or from the end of the one before it, whatever is sent
    meanwhile; the table, the poll that restarts the count, and the comparison take a cycle each.
    """
    for limit in (3, 8, 21):
        for ends, stopped in ((limit + 1, None), (limit + 2, 5 + limit + 4)):
            events = {0: {"watchdog": limit}, 5: section(0, 1), 5 + ends: {"i_collected": 0}}
            found = benches[1].run(Script(1, events), 5 + 2 * limit + 12)
            assert next((cycle for cycle, (_, said) in enumerate(found) if said["stops"]), None) == stopped
        events = {0: {"watchdog": limit}, 5: section(0, 1), 6: section(0, 2), 5 + limit: {"i_collected": 0},
                  5 + limit + 1: section(0, 3)}
        found = benches[1].run(Script(1, events), 3 * limit + 20)
        assert next(cycle for cycle, (_, said) in enumerate(found) if said["stops"]) == 5 + 2 * limit + 4


@pytest.mark.parametrize("bad", [1, 2])
def test_a_load_that_fails(benches, bad):
    """Of a descriptor it ends in its record; of a resume the queue stays halted."""
    plan = Plan(cycles=400, kinds=("load", "load", "section", "load", "section"), bad_loads=bad)
    found, units = play(benches, plan)
    assert codes(units.records)[:2] == ["READ_REPLY", "POINTER" if bad > 1 else "NONE"]
    assert not any(said["status"]["halted"] for _, said in found)
    found, units = play(benches, Plan(cycles=500, kinds=("load", *("section",) * 3), bad_loads=bad + 1, events={
        60: "stop", 61: "port reads"}))
    complete(units)
    assert "POINTER" in errors(found)
    assert found[-1][1]["taken"] == 4
    assert not found[-1][1]["status"]["halted"]


def test_tables_are_lost_by_a_load_that_fails_and_kept_by_one_of_some_regions(benches):
    """Until a load of all regions."""
    def load(regions, **over):
        return {"i_load": {"tag": 1, "image": 64, "regions": regions, "copies": 0}}, {"load_over": over}

    steps = [(1, {}, 0), ((1 << 13) - 1, {}, 1), (1, {}, 1), (2, READ_ERROR, 0), (2, {}, 0), ((1 << 13) - 1, {}, 1)]
    events = {0: {"o_record": 1}}
    for number, (regions, over, _) in enumerate(steps):
        begins, ends = load(regions, **over)
        events |= {10 * number + 2: begins, 10 * number + 6: ends}
    found = benches[1].run(Script(1, events), 70)
    assert [found[10 * number + 7][1]["loaded"] for number in range(len(steps))] == [loaded for *_, loaded in steps]


def test_a_load_waits_for_all_sections_and_the_sections_for_it(benches):
    """It is accepted when the last one has been collected; no descriptor is taken until its record is."""
    load = {"i_load": {"tag": 7, "image": 64, "regions": 1, "copies": 0}}
    events = {2: section(0, 1), 3: section(1, 2), 5: load, 8: {"i_collected": 0}, 10: load, 12: {"i_collected": 1},
              13: load, 20: {"load_over": {}}, 25: {"o_record": 1}}
    found = benches[2].run(Script(2, events), 32)
    assert [cycle for cycle, (given, said) in enumerate(found) if given["i_load"] and said["i_load"]] == [13]
    assert [cycle for cycle, (_, said) in enumerate(found) if not said["enable"]] == [*range(14, 26)]
    assert [one["tag"] for one in records_of(found)] == [7]


def test_a_ring_that_cannot_be_read(benches):
    """What is in flight ends, then the queue is halted; the same descriptor is read again after a resume."""
    for seed in range(2):
        kinds = ("load", "section", "section", "section", "unread", "section")
        events = {5: "port reads"} if seed % 2 else {}
        found, units = play(benches, Plan(cycles=500, seed=seed, kinds=kinds, events=events))
        complete(units)
        assert set(codes(units.records)) <= {"NONE"}
        code = "READ_OUTSIDE" if seed % 2 and found[20][0]["memory_fault"] else "READ_REPLY"
        assert errors(found) == [code]
        assert {said["error"]["number"] for _, said in found if said["error"]["code"]} == {RING + 4 * 192}
        assert found[-1][1]["taken"] == len(kinds)


def test_records_that_cannot_be_written(benches):
    """Those that were collected are kept, and the others aborted; a resume writes all of them."""
    for cycle in 40, 90:
        found, units = play(benches, Plan(cycles=cycle + 450, seed=cycle, kinds=("load", *("section",) * 8), events={
            cycle: "unwritten", cycle + 40: "unwritten"}))
        complete(units)
        assert "WRITE_REPLY" in errors(found)
        assert found[-1][1]["taken"] == 9


@pytest.mark.parametrize("port", ["READ_TIMEOUT", "READ_PROTOCOL", "WRITE_OUTSIDE", "WRITE_TIMEOUT", "WRITE_PROTOCOL"])
def test_the_fault_of_the_port_is_reported_for_its_direction_alone(benches, port):
    """Of a load, of the ring, and of a record."""
    fault = {"memory_fault": {"code": ErrorCode[port].value, "address": 8}}
    of_reads, of_writes = (port if port.startswith(kind) else f"{kind}_REPLY" for kind in ("READ", "WRITE"))
    load = {"i_load": {"tag": 1, "image": 64, "regions": 1, "copies": 0}}
    found = benches[1].run(Script(1, {2: load, 5: fault, 8: {"load_over": READ_ERROR}, 9: {"o_record": 1}}), 12)
    assert codes([said["o_record"] for _, said in found if said["o_record"]]) == [of_reads]
    for name, code in (("unread", of_reads), ("unwritten", of_writes)):
        assert errors(benches[1].run(Script(1, {4: fault, 8: {name: 1}}), 12)) == [code]


def test_commands_that_are_not_possible(benches):
    """A resume of a queue that runs, or that resumes already; no bit, or that of copies alone."""
    for event in "resume", "none":
        for cycle in (40, 41):
            found, _ = play(benches, Plan(cycles=60, events={cycle: event, 50: "clear"}))
            assert found[cycle + 1][1]["error"]["code"] == ErrorCode.COMMAND.value
            assert not found[51][1]["error"]["code"]
            assert not any(said["status"]["halted"] for _, said in found), "the queue goes on"
    for copies in 0, COPIES:
        events = {2: {"i_command": 1}, 9: {"i_command": 4 | copies}, 12: {"i_command": 4 | (COPIES - copies)}}
        found = benches[1].run(Script(1, events), 30)
        assert errors(found) == ["COMMAND"]
        assert {said["o_load"]["copies"] for _, said in found if said["o_load"]} == {int(copies > 0)}


def test_the_interrupt(benches):
    """It is pending when a record has been written and when the queue halts, until a 1 is written."""
    coverage = Coverage(["set by a record", "set by a halt", "cleared", "cleared and set at once", "enabled"])
    for seed in range(2):
        draw = random.Random(seed)
        events = {draw.randrange(250): "interrupt" for _ in range(80)} | {120: "stop"}
        found, _ = play(benches, Plan(seed=seed, cycles=350, events=events))
        for (before, _), (given, said), (_, after) in zip(found, found[1:], found[2:], strict=False):
            advances = given["completed"] != before["completed"]
            clears, (enabled, pending) = given["i_interrupt"] is not None and given["i_interrupt"] & 2, (
                after["interrupt_value"])
            sets = pending and not said["interrupt_value"][1]
            coverage.hit("set by a record", advances and sets)
            coverage.hit("set by a halt", said["stops"] and sets)
            coverage.hit("cleared", said["interrupt_value"][1] and not pending)
            coverage.hit("cleared and set at once", bool(clears and advances))
            coverage.hit("enabled", enabled)
            assert pending or not advances
    coverage.check()


@pytest.mark.parametrize("seed", [2, 3, *(pytest.param(seed, marks=pytest.mark.nightly) for seed in range(4, 60))])
def test_everything_at_random(benches, seed):
    """Several events, loads that fail, descriptors of all kinds, with and without a watchdog."""
    draw = random.Random(f"{SEED} {seed}")
    events = {draw.randrange(5, 400): draw.choice((*EVENTS, "clear", "none", "interrupt", "local", "port reads",
                                                  "port writes", "resume")) for _ in range(8)}
    kinds = ("load", *draw.choices(("section", "section", "section", "refused", "load", "part", "unread"), k=16))
    found, units = play(benches, Plan(
        nodes=1 + seed % 4, seed=seed, cycles=700, kinds=kinds, events=events, ring_bits=draw.randrange(5),
        watchdog=draw.choice((0, 0, 70, 120)), bad_loads=draw.randrange(3), busiest=draw.choice((0, 6, 30))))
    if not found[-1][1]["status"]["busy"]:
        complete(units)


def test_latency():
    assert documented_latency(JobControl, CONFIGS[2]) == JobControl.latency == 1
