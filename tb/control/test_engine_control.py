"""The engine's control beside its golden model, cycle by cycle: every command in every state, faults, the watchdog."""

import itertools
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.config import PRESETS
from golden.control.engine_control import ACTIVITIES, ALL_REGIONS, COMMANDS, EARLIER, RESETS
from hw.control.engine_control import EngineControl
from hw.control.load_control import ALL
from hw.registers.engine_registers import register
from hw.registers.error_code import ABOUT, ErrorCode
from tb.control.control_trace import CLUSTER_FAULTS, MEMORY_FAULTS, NETWORK_FAULTS, Plan, TraceBench, golden_trace
from tb.lib.coverage import Coverage
from tb.lib.schedules import SETTINGS
from tb.lib.timing import documented_latency

# The number of clusters is no power of two.
CONFIG = PRESETS["tiny"].replace({"noc.columns": 3, "noc.rows": 1})
NODES = 3
BITS = {name: (register("command").pack(**{name: 1}), False) for name in COMMANDS}
BITS |= {EARLIER: (BITS["write"][0], True), "none": (0, False)}
FAULTS = {"memory": MEMORY_FAULTS, "clusters": CLUSTER_FAULTS, "networks": NETWORK_FAULTS}


@pytest.fixture(scope="module")
def bench():
    return TraceBench(CONFIG)


def check(bench, plan):
    """The hardware says what the model does, in every cycle; the trace."""
    trace = golden_trace(plan, nodes=NODES)
    for cycle, ((seen, expected), found) in enumerate(zip(trace, bench.run(seen for seen, _ in trace), strict=True)):
        assert found == expected, f"cycle {cycle}, in which the control sees {seen}"
    return trace


def script(commands, **changes):
    """A plan of commands by cycle, by their names."""
    return Plan(commands={cycle: BITS[name] for cycle, name in commands.items()}, **changes)


# Two frusta, results of the first one beside the second one, another load.
TOUR = {3: "load", 10: "cast", 17: "write", 23: "cast", 26: EARLIER, 38: "load"}
TAKES = {"load": [(3, "NONE")], "cast": [(4, "NONE"), (9, "NONE")], "write": [(3, "NONE")]}
SCRIPTS = {
    "without an error": script(TOUR, cycles=60, takes=TAKES, regions=[ALL_REGIONS, 1]),
    "after an error": script({1: "none"} | TOUR, cycles=60, takes=TAKES, memory_busy=4),
    "watchdog": script(TOUR, cycles=60, takes=TAKES, watchdog=6, memory_busy=1),
}
IDLE = ("nothing loaded", "loaded", "a frustum", "two frusta")
IN_FLIGHT = ("load", "load of more", "cast", "cast of the next", "write", "write beside a cast")
STATES = (*(f"{name}{failed}" for name in IDLE + IN_FLIGHT for failed in ("", ", failed")),
          *(f"{name} starts" for name in ACTIVITIES), "stop", "watchdog")


def state(trace, cycle):
    """The state that a command finds, by what the model says."""
    _, said = trace[cycle]
    status = said.status
    if said.stops or said.starts:
        return "stop" if said.stops else f"{said.starts} starts"
    if cycle + 1 < len(trace) and trace[cycle + 1][1].error.code == "WATCHDOG" != said.error.code:
        return "watchdog"
    if status["loads"]:
        name = "load of more" if status["loaded"] else "load"
    elif status["writes"]:
        name = "write beside a cast" if status["casts"] else "write"
    elif status["casts"]:
        name = "cast of the next" if status["earlier"] else "cast"
    else:
        name = IDLE[1 + status["present"] + status["earlier"]] if status["loaded"] else IDLE[0]
    return name + (", failed" if status["failed"] else "")


def test_every_command_in_every_state(bench):
    coverage = Coverage(f"{command}: {state}" for command in BITS for state in STATES)
    for plan, name in itertools.product(SCRIPTS.values(), BITS):
        for cycle in range(plan.cycles - 8):
            changed = replace(plan, commands=plan.commands | {cycle: BITS[name]}, cycles=max(40, cycle + 20))
            coverage.hit(f"{name}: {state(check(bench, changed), cycle)}")
    coverage.check()


@pytest.mark.parametrize("source", ["memory", "clusters", "timeout", "networks"])
def test_a_fault_in_every_state(bench, source):
    coverage = Coverage(STATES)
    for plan in SCRIPTS.values():
        for cycle in range(plan.cycles - 8):
            changed = replace(plan, **happens(source, cycle, "load"), cycles=max(40, cycle + 20))
            coverage.hit(state(check(bench, changed), cycle))
    coverage.check()


def test_of_several_commands_the_lowest_counts(bench):
    for value in range(1 << register("command").width):
        for cycle in 1, 8, 24:
            trace = check(bench, Plan(cycles=cycle + 12, takes=TAKES, memory_busy=2, commands={
                **{at: BITS[name] for at, name in TOUR.items() if at < cycle}, cycle: (value, False)}))
            assert trace[cycle][0].command_name == next((name for bit, name in enumerate(COMMANDS) if value >> bit & 1),
                                                        "none")


# The cycle of one event; the other one is some cycles before or after it.
MEETING = 30


def happens(name, cycle, activity):
    """Changes of a plan by which an event occurs in a cycle; in the plan the activity begins in cycle 16."""
    if name in BITS:
        return {"commands": {cycle: BITS[name]}}
    if name == "end":
        return {"takes": {activity: [*TAKES[activity][:activity == "load"], (cycle - 16, "POINTER")]}}
    if name == "watchdog":
        return {"watchdog": cycle - 18}
    source, code = {"timeout": ("clusters", "PATH_TIMEOUT")}.get(name, (name, FAULTS.get(name, [0])[0]))
    return {"faults": [(cycle, source, int(source != "memory"), code, 77 * (source != "networks"))]}


@pytest.mark.parametrize("activity", ["load", "write"])
def test_two_events_at_once(bench, activity):
    """The order of errors, and clears and stops beside them."""
    events = ("end", "watchdog", "memory", "clusters", "timeout", "networks", "none", "clear", "stop", "cast")
    seen = set()
    for (one, other), delay in itertools.product(itertools.combinations(events, 2), range(-3, 4)):
        plan = script({3: "load", 9: "cast", 15: activity}, cycles=MEETING + 16, memory_busy=3,
                      takes={"load": [(3, "NONE"), (40, "NONE")], "cast": [(3, "NONE")], "write": [(40, "NONE")]})
        for name, cycle in (one, MEETING), (other, MEETING + delay):
            for field, value in happens(name, cycle, activity).items():
                now = getattr(plan, field)
                now = value if field == "watchdog" else now + value if field == "faults" else now | value
                plan = replace(plan, **{field: now})
        seen |= {said.error.code for _, said in check(bench, plan)}
    assert seen == {"NONE", "WATCHDOG", "POINTER", "READ_OUTSIDE", "PATH_CELL", "PATH_TIMEOUT", "NETWORK_CHECK",
                    "COMMAND"}


@pytest.mark.parametrize("limit", [2, 3, 9])
@pytest.mark.parametrize("activity", ["load", "cast", "write"])
def test_the_watchdog_counts_from_the_start(bench, activity, limit):
    """``status`` shows an activity while it is busy and in the cycle before. Here it does so for as many cycles as the
    watchdog allows, for one fewer and for one more.
    """
    once = (1, "NONE")
    for shown in range(limit - 1, limit + 2):
        busy = (shown - 1, "NONE")
        trace = check(bench, script({3: "load", 12: "cast", 20: activity}, cycles=limit + 30, memory_busy=2,
                                    watchdog=limit,
                                    takes={"load": [once, busy], "cast": [once, busy], "write": [busy]}))
        assert sum(said.status[f"{activity}s"] for _, said in trace[20:]) == shown
        assert (trace[-1][1].error.code == "WATCHDOG") == (shown > limit)


@pytest.mark.parametrize("regions", [ALL, ALL & ~1, ALL | 1 << 4, 0, (1 << register("regions").width) - 1])
def test_a_cast_needs_all_regions_at_once(bench, regions):
    """One load without a fault has all of them; loads of parts may follow, but none with a fault."""
    for fault in "NONE", "POINTER":
        plan = script({3: "load", 10: "load", 16: "cast"}, cycles=30, regions=[ALL, regions],
                      takes={"load": [(3, "POINTER"), (3, fault)]})
        trace = check(bench, plan)
        assert trace[-1][1].status["loaded"] == (fault == "NONE" and regions & ALL == ALL)
        for first in "NONE", fault:
            check(bench, replace(plan, takes={"load": [(3, first), (3, fault)]}))


def plans():
    """Commands, durations, faults and a watchdog at random."""
    gap = st.sampled_from((2, 2, 3, 5, 9, 17))
    name = st.sampled_from(("load", "cast", "cast", "write", EARLIER, EARLIER, "clear", "stop", "none"))
    take = st.tuples(st.integers(1, 20), st.sampled_from(("NONE",) * 6 + tuple(MEMORY_FAULTS)))
    source = st.sampled_from(sorted(FAULTS)).flatmap(lambda source: st.tuples(
        st.integers(0, 150), st.just(source), st.integers(0, 0 if source == "memory" else NODES - 1),
        st.sampled_from(FAULTS[source]), st.integers(0, 0 if source == "networks" else (1 << 24) - 1)))

    def plan(commands, takes, watchdog, regions, faults, memory_busy):
        cycles = itertools.accumulate(gap for gap, _ in commands)
        commands = {1: BITS["load"], 10: BITS["cast"]} | {
            18 + cycle: BITS[name] for cycle, (_, name) in zip(cycles, commands, strict=True)}
        return Plan(cycles=40 + max(commands), commands=commands, takes=takes, watchdog=watchdog, regions=regions,
                    faults=faults, memory_busy=memory_busy)

    takes = {name: st.lists(take, min_size=1, max_size=6) for name in ACTIVITIES}
    takes["load"] = takes["load"].map(lambda some: [(4, "NONE"), *some])
    return st.builds(
        plan, st.lists(st.tuples(gap, name), max_size=20), st.fixed_dictionaries(takes),
        st.sampled_from((0, 0, 6, 15, 30, (1 << 32) - 1)),
        st.lists(st.sampled_from((ALL_REGIONS, ALL_REGIONS, 1)), max_size=4).map(lambda some: [ALL_REGIONS, *some]),
        st.lists(source, max_size=3), st.integers(0, 5))


def test_random_sequences(bench):
    @settings(SETTINGS, max_examples=200)
    @given(plans())
    def run(plan):
        check(bench, plan)

    run()


def test_errors_of_all_units(bench):
    """Each code at every moment of the polling, with its cluster and number."""
    seen = set()
    for source, codes in FAULTS.items():
        for code, cycle in itertools.product(codes, range(20, 23)):
            for cluster in range(1 if source == "memory" else NODES):
                number = 0 if source == "networks" else 1000 + cycle
                trace = check(bench, script(
                    {3: "load", 10: "cast", 34: "clear"}, cycles=44, takes={"cast": [(40, "NONE")]}, memory_busy=3,
                    faults=[(cycle, source, cluster, code, number)]))
                error = trace[34][1].error
                assert (error.code, error.cluster, error.number) == (code, cluster, number)
                assert trace[-1][1].status["loaded"] == (code not in RESETS)
                seen.add(code)
    others = {"NONE", "COMMAND", "NOT_LOADED", "WATCHDOG", "ABORTED", "DESCRIPTOR", "RING"}
    assert seen | others == {one.name for one in ErrorCode}


def test_what_the_model_takes_from_the_documents():
    assert ALL == ALL_REGIONS
    assert {name for name, about in ABOUT.items() if "ends in a reset" in about} == RESETS
    assert tuple(field.name for field in register("command").fields) == COMMANDS


def test_latency():
    assert documented_latency(EngineControl, CONFIG) == EngineControl.latency == 1
