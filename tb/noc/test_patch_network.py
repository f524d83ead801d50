"""Protocol: requests wait for replies, replies wait for nothing."""

import pytest
from amaranth.hdl import Fragment

from golden.engine.config import PRESETS
from golden.engine.noc.packing import reply_flits, request_flits
from hw.lib.arbiter import ArbiterPolicy
from hw.lib.credit_gate import CreditGate
from hw.noc import network_interface, output_port
from hw.noc.patch_network import PatchNetwork
from tb.lib.drawn import drawn
from tb.lib.runner import ICARUS, simulate
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

TESTS = ("all_are_answered", "a_stalled_cluster_blocks_no_other")
SMALL = {"noc.rows": 1, "noc.buffer_flits": 2, "noc.flit_bits": 72, "noc.check": "parity"}
NETWORKS = {"two": SMALL | {"noc.columns": 3, "noc.virtual_channels": 1, "noc.networks": "physical"},
            "one": SMALL | {"noc.topology": "ring", "noc.columns": 4, "noc.virtual_channels": 2,
                            "noc.networks": "virtual"}}
LARGE = {"mesh": {"noc.topology": "mesh", "noc.columns": 4, "noc.rows": 4, "noc.virtual_channels": 1,
                  "noc.networks": "physical"},
         "torus": {"noc.topology": "torus", "noc.columns": 4, "noc.rows": 4, "noc.virtual_channels": 2,
                   "noc.networks": "virtual", "noc.flit_bits": 32, "noc.check": "crc", "noc.arbitration": "age"},
         "cube": {"noc.topology": "hypercube", "noc.columns": 4, "noc.rows": 2, "noc.virtual_channels": 2,
                  "noc.networks": "virtual", "noc.flit_bits": 40, "noc.check": "none"}}


def run(name, config, tests, *, simulator, requests, progress=True):
    network = PatchNetwork(config=PRESETS["tiny"].replace(config))
    simulate(network, "tb.noc.clusters", tests, simulator=simulator, name=f"patch-network-{name}-{simulator}",
             config=config, requests=requests, progress=progress)


@pytest.mark.parametrize(("name", "simulator", "requests"), [
    pytest.param("two", "icarus", 10, marks=ICARUS.marks),
    pytest.param("one", "verilator", 150, marks=pytest.mark.sim)])
def test_full_networks_drain_and_a_stalled_cluster_blocks_no_other(name, simulator, requests):
    run(name, NETWORKS[name], TESTS, simulator=simulator, requests=requests)


@pytest.mark.nightly
@pytest.mark.parametrize("name", drawn([*LARGE]))
def test_large_ones_too(name):
    run(name, LARGE[name], TESTS, simulator="verilator", requests=150)


class _TooManyCredits(CreditGate):
    def __init__(self, shape, *, credits):
        super().__init__(shape, credits=8 * credits)


@pytest.mark.parametrize("simulator", [ICARUS])
def test_requests_without_reserved_entries_block_others(monkeypatch, simulator):
    monkeypatch.setattr(network_interface, "CreditGate", _TooManyCredits)
    run("greedy", NETWORKS["two"], TESTS[1:], simulator=simulator, requests=30, progress=False)


@pytest.mark.parametrize("router_cycles", [1, 2])
def test_a_request_alone_takes_what_the_docstring_says(router_cycles):
    """And stalls nowhere."""
    config = PRESETS["tiny"].replace({"noc.router_cycles": router_cycles, "noc.networks": "virtual"})
    bench = ScheduleBench(PatchNetwork(config=config), watched=["flits", "stalls"])
    came = bench.run(Schedule(items={"i_request__0": [(0, {"node": 1, "patch": 77})]}))
    assert came["o_request__1"] == [{"node": 0, "patch": 77}]
    latency = documented_latency(PatchNetwork, config, hops=1)
    assert bench.cycles["o_request__1"][0] - bench.cycles["i_request__0"][0] == latency
    assert bench.history["flits"][-1] > 0
    assert bench.history["stalls"][-1] == 0


@pytest.mark.parametrize("networks", ["virtual", "physical"])
@pytest.mark.parametrize(("arbitration", "policy"), [
    ("round-robin", ArbiterPolicy.ROUND_ROBIN), ("age", ArbiterPolicy.LONGEST_WAITING)])
def test_every_port_has_the_arbitration_of_the_configuration(monkeypatch, networks, arbitration, policy):
    """What it does is tested at the network, `tb/noc/test_network.py`."""
    found, make = [], output_port.OutputPort.__init__

    def record(self, **given):
        found.append(given["policy"])
        make(self, **given)

    monkeypatch.setattr(output_port.OutputPort, "__init__", record)
    config = PRESETS["tiny"].replace({"noc.networks": networks, "noc.arbitration": arbitration})
    Fragment.get(PatchNetwork(config=config), None)
    assert found
    assert set(found) == {policy}


@pytest.mark.parametrize("networks", ["virtual", "physical"])
def test_flits_are_those_of_requests_and_of_replies(networks):
    """Two routers pass each of them, in channels of its kind to the end."""
    config = PRESETS["tiny"].replace({"noc.networks": networks, "noc.virtual_channels": 2})
    corners = [[1, 2, 3]] * 4
    bench = ScheduleBench(PatchNetwork(config=config), idle_limit=40, watched=["flits"])
    reply = [{"node": 0, "vertex": {"patch": 7, "surface": 0, "vertex": corner}} for corner in corners]
    came = bench.run(Schedule(items={"i_request__0": [(0, {"node": 1, "patch": 7})],
                                     "i_reply__1": [(0, vertex) for vertex in reply]}))
    assert {name: items for name, items in came.items() if items} == {
        "o_request__1": [{"node": 0, "patch": 7}], "o_reply__0": [vertex["vertex"] for vertex in reply]}
    count = len(request_flits(config, source=0, destination=1, patch=7)) + len(reply_flits(
        config, source=1, destination=0, patch=7, surface=0, vertices=corners))
    assert bench.history["flits"][-1] == 2 * count


def test_stalls_are_those_of_requests_and_of_replies():
    """Packets of two nodes meet on their way to a third one: of replies that it has requested, then of requests."""
    bench = ScheduleBench(PatchNetwork(config=PRESETS["tiny"].replace(NETWORKS["two"])), idle_limit=150,
                          watched=["stalls"])
    count, vertices = 2, 4

    def after(cycles, items):
        return [(0 if number else cycles, item) for number, item in enumerate(items)]

    bench.run(Schedule(items={
        "i_request__2": after(0, [{"node": sender, "patch": patch} for sender in range(2) for patch in range(count)]),
        **{f"i_reply__{sender}": after(100, [
            {"node": 2, "vertex": {"patch": patch, "surface": 0, "vertex": [1, 2, 3]}}
            for patch in range(count) for _ in range(vertices)]) for sender in range(2)},
        **{f"i_request__{sender}": after(220, [{"node": 2, "patch": patch} for patch in range(count)])
           for sender in range(2)}}))
    assert len(bench.cycles["o_reply__2"]) == 2 * count * vertices
    assert max(bench.cycles["o_reply__2"]) < 220
    stalls = [bench.history["stalls"][cycle] for cycle in (99, 219, -1)]
    assert stalls[0] < stalls[1] < stalls[2]
