"""The paper's machine with any number of clusters is simulated by a command."""

import json
from dataclasses import asdict

import pytest
from click.testing import CliRunner

import radiosity.cli.main
from golden.engine.config import PRESETS
from radiosity.machines.paper.paper_latencies import paper_timing
from radiosity.machines.paper.paper_machine import PaperMachine, PaperSpec
from radiosity.machines.paper.paper_timing import PaperTiming
from radiosity.machines.paper.supply import Supply

pytestmark = [pytest.mark.xdist_group("machines"), pytest.mark.usefixtures("interpreted")]

SMALL = ("cornell", "--rays", "32x16", "--cell", "0.5", "--ratio", "16")


def timing():
    """Of the smallest configuration."""
    return paper_timing(PRESETS["tiny"], latency=10)


def run(*words):
    return CliRunner().invoke(radiosity.cli.main.main, ["machine", "paper", *SMALL, *words])


def test_the_command_prints_one_object():
    done = run("--nodes", "4", "--steps", "2", "--json")
    report = json.loads(done.output)
    assert {"cycles", "efficiency", "traffic", "memory", "of_a_node"} <= report.keys()
    assert (done.exit_code, report["differences"]) == (0, 0)
    assert (report["nodes"], report["traversal_units"], report["frusta"], report["is_extrapolated"]) == (4, 8, 2, False)
    assert report["cycles"] == sum(report["step_cycles"])
    assert len(set(report["sources"])) == 2
    assert report["tests"] == report["of_a_node"]["tests"]["mean"] * 4
    assert report["efficiency"] == pytest.approx(report["tests"] / 4 / report["cycles"])
    memory, each = report["memory"], report["of_a_node"]
    references = memory["resident_references"] + memory["cache_hits"] + memory["main_references"]
    assert references == each["references"]["mean"] * 4


def test_supplies_have_their_own_traffic():
    machine = PaperMachine(PaperSpec(scene="cornell", rays=(32, 16), cell=0.5, ratio=16), PRESETS["paper"], nodes=2)
    pushed, pulled, main = (machine.run(supply).report()["traffic"] for supply in (
        Supply.PUSHED, Supply.PULLED, Supply.MAIN))
    assert pushed["pushed"]
    assert (pulled["pushed"], main["pushed"]) == (0, 0)
    assert pushed["requested"] < main["requested"] <= pulled["requested"]


@pytest.mark.parametrize("supply", Supply)
def test_nodes_receive_what_steps_bring_and_not_what_they_keep(supply):
    machine = PaperMachine(PaperSpec(scene="cornell", steps=3, rays=(32, 16), cell=0.5, ratio=16), PRESETS["paper"],
                           nodes=2)
    run = machine.run(supply)
    kept, brought = [set(), set()], 0
    for step in run.steps:
        plan = step.prepared.plan
        resident = [set(own.tolist() if supply is Supply.PUSHED else ()) for own in plan.resident]
        lacking = set().union(*(own - held for own, held in zip(resident, kept, strict=True)))
        brought += sum(patch in resident[cluster] for patch in lacking.intersection(plan.found.tolist())
                       for cluster in plan.tags.destinations(patch).tolist())
        kept = [memory.held for memory in step.memories]
    received = run.report()["of_a_node"]["received"]
    assert received["mean"] * 2 == brought + run.total("misses")


def test_the_command_has_all_supplies():
    options = {option.name: option for option in radiosity.cli.main.main.commands["machine"].commands["paper"].params}
    assert list(options["supply"].type.choices) == [supply.value for supply in Supply]


def test_text_marks_what_is_extrapolated():
    output = run("--nodes", "32").output
    assert "(extrapolated)" in output
    assert "32 clusters, 64 traversal units, patches pushed" in output
    assert "golden: 0 differences" in output


@pytest.mark.parametrize(("words", "message"), [
    (("--nodes", "12"), "--nodes: Nodes must be a power of two up to 1024, not 12"),
    (("--nodes", "2048"), "--nodes: Nodes must be a power of two up to 1024, not 2048"),
    (("--nodes", "4", "--units", "3"), "--units: Traversal units must be at least 4, one for each cluster, not 3"),
    (("--ratio", "3"), "--ratio: Ratio must be a power of two, not 3"),
    (("--rays", "30x16"), "--rays: Azimuths must be a power of two"),
    (("--nodes", "1024"), "32 x 16 rays cannot be cut for 1024 clusters")])
def test_wrong_machines_are_refused(words, message):
    done = run(*words)
    assert done.exit_code == 2
    assert message in done.output
    assert done.output.count("\n") == 1


def test_a_hit_that_differs_is_a_failure(monkeypatch):
    monkeypatch.setattr("radiosity.machines.paper.paper_machine.PaperMachine.differences", lambda self: 3)
    done = run("--nodes", "1")
    assert (done.exit_code, "golden: 3 differences" in done.output) == (1, True)


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"setup": -1}, ValueError, "Setup must be at least 0, not -1"),
    ({"words": 0}, ValueError, "Words must be at least 1, not 0"),
    ({"requests": 0}, ValueError, "Requests must be at least 1, not 0"),
    ({"main": 1.5}, TypeError, "Main must be an int, not 1.5")])
def test_numbers_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        PaperTiming(**{**asdict(timing()), **wrong})


def test_latencies_follow_the_configuration():
    tiny = PRESETS["tiny"]
    slower = paper_timing(tiny.replace({"noc.router_cycles": 3 - tiny.noc.router_cycles,
                                        "icu.product_registers": tiny.icu.product_registers + 1}), latency=30)
    assert slower.switch != timing().switch
    assert slower.setup > timing().setup
    assert (timing().main, slower.main) == (10, 30)
