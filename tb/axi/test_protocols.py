"""Each rule: a trace with one fault violates it and no other; component and monitor agree."""

import random
from types import SimpleNamespace

import pytest
from amaranth.hdl import Cat, ClockDomain, Module, Signal

from tb.axi.axi_lite_protocol import AxiLiteProtocol
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.channels import PYTHON
from tb.axi.protocol_checker import ProtocolChecker
from tb.axi.protocol_monitor import ProtocolError, ProtocolMonitor
from tb.lib.configurations import config_of
from tb.lib.simulator import simulator_of

SMALL = {"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 4, "memory.length_bits": 3,
         "memory.timeout_bits": 2}
PROTOCOLS = {"axi": lambda **more: AxiProtocol(config_of(SMALL | more)), "lite": lambda: AxiLiteProtocol(4)}


def cycle(*channels, **pins):
    """Pins of a cycle in which some channels are valid, with a ready in capitals."""
    return {f"{channel.lower()}valid": 1 for channel in channels} | {
        f"{channel.lower()}ready": 1 for channel in channels if channel.isupper()} | pins


def axi_address(channel, length, *, at=0x100, identifier=0):
    names = ("id", "addr", "len", "size", "burst", "cache", "prot")
    return {f"{channel}{name}": value for name, value in zip(names, (identifier, at, length, 3, 1, 3, 2), strict=True)}


# Two beats of a write and of a read, each channel stalled for a cycle; then one of each without a stall; a reset in the
# next to last cycle.
WRITE, READ = axi_address("aw", 1), axi_address("ar", 1)
ONE = axi_address("aw", 0) | axi_address("ar", 0, identifier=1)
MORE = {10: cycle("AW", "AR", **ONE)}
GOOD = {
    "axi": [
        {}, cycle("aw", "w", "ar", wdata=5, **WRITE, **READ), cycle("AW", "W", "AR", wdata=5, **WRITE, **READ),
        cycle("w", "r", wlast=1, rdata=3), cycle("W", "R", wlast=1, rdata=3), cycle("b", "r", rlast=1),
        cycle("B", "R", rlast=1), {}, cycle("AW", "W", "AR", wlast=1, **ONE), cycle("B", "R", rid=1, rlast=1),
        {}, {}, {}, {"reset": 1}, {}],
    "lite": [
        {}, cycle("aw", "ar", awaddr=4, araddr=8), cycle("AW", "AR", "w", awaddr=4, araddr=8, wdata=1),
        cycle("W", "r", wdata=1, rdata=7), cycle("b", "R", rdata=7), cycle("B"), {}, cycle("AW", "W", "AR"),
        cycle("AW", "W", "AR", "B", "R"), cycle("B", "R"), {}, {}, {}, {"reset": 1}, {}],
}
# By rule: what is different in some cycles. None: nothing occurs in the cycle.
FAULTS = {
    "axi": {
        "aw_stable": [{2: {"awaddr": 0x108}}, {2: {"awprot": 0}}, {2: {"awvalid": 0}}], "aw_reset": [{14: MORE[10] | {
            "arvalid": 0}}],
        "w_stable": [{2: {"wdata": 6}}, {2: {"wstrb": 1}}], "w_reset": [{14: cycle("w")}],
        "b_stable": [{6: {"bresp": 2}}, {6: {"bvalid": 0}}], "b_reset": [{14: cycle("b")}],
        "ar_stable": [{2: {"araddr": 0x108}}], "ar_reset": [{14: MORE[10] | {"awvalid": 0}}],
        "r_stable": [{4: {"rdata": 4}}, {4: {"rresp": 2}}], "r_reset": [{14: cycle("r")}],
        "aw_burst": [{8: {"awburst": 0}}, {8: {"awburst": 2}}], "ar_burst": [{8: {"arburst": 2}}],
        "aw_cache": [{8: {"awcache": 2}}], "ar_cache": [{8: {"arcache": 7}}],
        "aw_size": [{8: {"awsize": 2}}, {8: {"awaddr": 0x104}}], "ar_size": [{8: {"arsize": 4}}],
        "aw_length": [{10: MORE[10] | {"awlen": 4}}], "ar_length": [{10: MORE[10] | {"arlen": 255}}],
        "aw_page": [{10: MORE[10] | {"awlen": 1, "awaddr": 0x1FF8}}],
        "ar_page": [{10: MORE[10] | {"arlen": 3, "araddr": 0x1FE8}}],
        "aw_id": [{8: {"awid": 1}}], "ar_id": [{k: cycle("AR", **axi_address("ar", k - 10)) for k in (10, 11)}],
        "aw_count": [{k: cycle("AW", **axi_address("aw", 0)) for k in (10, 11, 12)}],
        "ar_count": [{k: cycle("AR", **axi_address("ar", 0, identifier=k - 10)) for k in (10, 11)}],
        "w_announced": [{10: cycle("W", wlast=1)}, {7: cycle("w", wlast=1), 8: {"wvalid": 1}}],
        "w_last": [{8: {"wlast": 0}}, {1: {"wlast": 1}, 2: {"wlast": 1}}, {3: {"wlast": 0}, 4: {"wlast": 0}}],
        "b_id": [{10: cycle("B", bid=1)}],
        "b_due": [{10: cycle("B")}, {4: {"bvalid": 1, "bready": 1}, 5: {"bvalid": 0}, 6: {"bvalid": 0}},
                  {8: {"awready": 0}, 9: {**ONE, "awvalid": 1, "awready": 1, "arvalid": 0}}],
        "r_id": [{10: cycle("R", rlast=1)}, {9: {"rid": 0}}],
        "r_last": [{5: {"rlast": 0}, 6: {"rlast": 0}}, {3: {"rlast": 1}, 4: {"rlast": 1}, 5: {"rvalid": 0},
                                                       6: {"rvalid": 0}}],
        "b_resp": [{9: {"bresp": 1}}], "r_resp": [{9: {"rresp": 1}}],
    },
    "lite": {
        "aw_stable": [{2: {"awaddr": 8}}, {2: {"awvalid": 0, "awready": 0}, 3: {"awvalid": 1, "awready": 1}}],
        "aw_reset": [{14: cycle("aw")}], "w_stable": [{3: {"wdata": 2}}, {3: {"wstrb": 1}}],
        "w_reset": [{14: cycle("w")}], "ar_stable": [{2: {"araddr": 4}}], "ar_reset": [{14: cycle("ar")}],
        "b_stable": [{5: {"bresp": 2}}], "b_reset": [{14: cycle("b")}], "r_stable": [{4: {"rdata": 8}}],
        "r_reset": [{14: cycle("r")}],
        "aw_count": [{k: cycle("AW") for k in (10, 11, 12)}], "w_count": [{k: cycle("W") for k in (10, 11, 12)}],
        "ar_count": [{k: cycle("AR") for k in (10, 11, 12)}],
        "b_due": [{10: cycle("B")}, {10: cycle("AW"), 11: cycle("B")}, {10: cycle("W"), 11: cycle("B")},
                  {3: {"bvalid": 1, "bready": 1}, 4: {"bvalid": 0}}],
        "r_due": [{10: cycle("R")}, {2: {"rvalid": 1, "rready": 1}}], "b_resp": [{5: {"bresp": 1}, 4: {"bresp": 1}}],
        "r_resp": [{9: {"rresp": 1}}],
    },
}
CASES = [(name, rule, k) for name, faults in FAULTS.items() for rule, edits in faults.items()
         for k in range(len(edits))]


def traced(name, changes=None):
    return [pins | (changes or {}).get(k, {}) for k, pins in enumerate(GOOD[name])]


def protocol_of(name, rule=None):
    # With as many outstanding reads as ids `ar_id` would be violated first, so here there are more ids.
    return PROTOCOLS[name](**({"memory.outstanding": 1} if rule == "ar_count" and name == "axi" else {}))


def watched(protocol, trace):
    """The rules that the monitor finds violated, by cycle."""
    monitor = ProtocolMonitor(protocol)
    return [set(monitor.violated(dict.fromkeys(protocol.pins, 0) | pins, reset=pins.get("reset", 0)))
            for pins in trace]


def checked(protocol, trace):
    """What the component finds."""
    top, checker = Module(), ProtocolChecker(protocol)
    top.domains.sync = domain = ClockDomain()
    top.submodules.checker = checker
    pins = {name: getattr(checker.port, name) for name in protocol.pins}
    given, found, offsets, at = Signal(sum(map(len, pins.values()))), [], {}, 0
    for name, pin in pins.items():
        offsets[name] = at
        at += len(pin)
    top.d.comb += Cat(pins.values()).eq(given)
    names = list(checker.violated.shape().members)

    async def run(context):
        for one in trace:
            context.set(given, sum(value << offsets[name] for name, value in one.items() if name != "reset"))
            context.set(domain.rst, one.get("reset", 0))
            bits = context.get(checker.violated.as_value())
            found.append({name for k, name in enumerate(names) if bits >> k & 1})
            await context.tick()

    simulator_of(top, run).run()
    return found


@pytest.mark.parametrize("name", PROTOCOLS)
def test_every_rule_has_a_negative_control(name):
    protocol = PROTOCOLS[name]()
    rules = protocol.manager + protocol.subordinate
    # Names, as are those of the states below.
    assert set(FAULTS[name]) == set(rules)
    assert len(set(rules)) == len(rules)
    zeros = SimpleNamespace(reset=0, **dict.fromkeys(protocol.pins, 0))
    state = {name: [init for _, init in words] for name, words in protocol.state.items()}
    violated, following = protocol.step(zeros, state, PYTHON)
    assert (violated.keys(), following.keys()) == ({*rules}, state.keys())


@pytest.mark.parametrize("name", PROTOCOLS)
def test_a_trace_without_fault(name):
    for rule in (None, "ar_count"):
        assert not any(watched(protocol_of(name, rule), traced(name)))


@pytest.mark.parametrize(("name", "rule", "k"), CASES)
def test_one_fault_violates_one_rule(name, rule, k):
    protocol, trace = protocol_of(name, rule), traced(name, FAULTS[name][rule][k])
    found = watched(protocol, trace)
    assert set.union(*found) == {rule}
    assert checked(protocol, trace) == found


def test_a_violation_is_an_error_unless_the_rule_is_left_out():
    protocol = PROTOCOLS["axi"]()
    pins = dict.fromkeys(protocol.pins, 0) | cycle("R", rlast=1)
    ProtocolMonitor(protocol, protocol.manager).step(pins)
    with pytest.raises(ProtocolError, match="r_reset"):
        ProtocolMonitor(protocol).step(pins)


@pytest.mark.parametrize("name", PROTOCOLS)
def test_component_and_monitor_agree(name):
    """Pins at random, mostly near what is allowed."""
    protocol, draw, seen = PROTOCOLS[name](), random.Random(1), set()
    trace = []
    for k in range(3000):
        pins = {pin: draw.getrandbits(width) for pin, width in protocol.pins.items()}
        if name == "axi":
            pins |= {pin: draw.choice(values) for pin, values in {
                "awlen": (0, 1, 3, 4), "arlen": (0, 1, 3, 4), "awsize": (3, 3, 2), "arsize": (3, 3, 2),
                "awburst": (1, 1, 0), "arburst": (1, 1, 2), "awcache": (3, 3, 0), "arcache": (3, 3, 11),
                "awid": (0, 0, 1), "bid": (0, 0, 1)}.items()}
        # Often as before, and often quiet.
        pins |= {pin: value for pin, value in (trace[-1] if trace else {}).items()
                 if pin != "reset" and draw.random() < 0.7}
        pins |= {pin: 0 for pin in pins if pin.endswith("valid") and draw.random() < 0.3 * (k // 300 % 3)}
        trace.append(pins | {"reset": int(draw.random() < 0.02)})
    found = watched(protocol, trace)
    assert found == checked(protocol, trace)
    seen = set.union(*found)
    assert seen == set(protocol.manager + protocol.subordinate), "each rule is violated somewhere"
