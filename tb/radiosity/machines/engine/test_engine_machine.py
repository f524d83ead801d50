"""The engine with any number of clusters is simulated by commands."""

import json
import math
from dataclasses import replace

import pytest
from click.testing import CliRunner

import radiosity.cli.main
from benchmarks.scaling import divisions, strong_runs, weak_run
from golden.engine.config import PRESETS
from golden.engine.jobs.result_formats import HitFormat
from radiosity.machines.engine.engine_machine import CALIBRATED, EngineMachine, EngineRun
from radiosity.machines.engine.job_latencies import job_timing
from radiosity.machines.engine.job_runs import JobSpec

pytestmark = [pytest.mark.xdist_group("machines"), pytest.mark.usefixtures("interpreted")]

SMALL = ("cornell", "--frusta", "4", "--rays", "16x16", "--cell", "1")
SPEC = JobSpec(scene="cornell", rays=(16, 16), frusta=4, cell=1.0)


@pytest.fixture(scope="module")
def casts(tmp_path_factory):
    """Where casts are kept, which several machines have in common."""
    return tmp_path_factory.mktemp("casts")


def run(*words):
    return CliRunner().invoke(radiosity.cli.main.main, ["machine", "engine", *words])


def test_the_command_prints_one_object(tmp_path):
    report = json.loads(run(*SMALL, "--nodes", "4", "--casts", str(tmp_path), "--json").output)
    assert {"cycles", "efficiency", "traffic", "memory", "of_a_node"} <= report.keys()
    assert (report["nodes"], report["groups"], report["sections"], report["is_extrapolated"]) == (4, 4, 4, False)
    assert report["cycles"] > max(report["bounds"].values())
    assert report["of_a_node"]["sections"] == {"least": 1, "mean": 1.0, "most": 1}
    assert report["tests"] == report["of_a_node"]["tests"]["mean"] * 4
    assert len([*tmp_path.iterdir()]) == 4


def test_text_marks_what_is_extrapolated(casts, monkeypatch):
    """What is larger than all hardware, which here has a cluster."""
    monkeypatch.setattr("radiosity.machines.engine.engine_machine.CALIBRATED", 1)
    output = run(*SMALL, "--nodes", "4", "--groups", "2", "--casts", str(casts)).output
    assert "(extrapolated)" in output
    assert "4 clusters in 2 groups, 8 sections" in output


def test_what_is_larger_than_all_hardware_is_extrapolated():
    runs = [EngineRun(prepared=None, job=None, nodes=nodes, groups=1, simulated=None, dispatch=0)
            for nodes in (CALIBRATED, 2 * CALIBRATED)]
    assert [run.is_extrapolated for run in runs] == [False, True]


def test_a_part_of_a_cycle_bounds_a_job_as_a_whole_one(casts):
    """Casts are shared out to the clusters; the dispatcher reads two near cells of a section in a cycle."""
    run = EngineMachine(SPEC, PRESETS["paper"], folder=casts).run(4, 4)
    cycles, near = run.simulated.cast_cycles, run.job.descriptors["near_count"].tolist()
    # Otherwise nothing would be rounded.
    assert cycles % 4
    assert run.bounds["casts"] == math.ceil(cycles / 4)
    sections = len(run.simulated.casts) * job_timing(run.job.config, latency=10).dispatch
    assert run.bounds["dispatch"] == sections + sum(math.ceil(count / 2) for count in near)


def test_the_longest_section_ends_with_its_results(casts):
    run = EngineMachine(replace(SPEC, hit_format=HitFormat.FULL), PRESETS["paper"], folder=casts).run(1, 1)
    times = run.simulated.times
    assert run.bounds["longest section"] == (times.done - times.begins).max() > (times.ends - times.begins).max()


@pytest.mark.parametrize(("words", "message"), [
    (("--nodes", "12"), "--nodes: Nodes must be a power of two up to 1024, not 12"),
    (("--nodes", "2048"), "--nodes: Nodes must be a power of two up to 1024, not 2048"),
    (("--nodes", "4", "--groups", "8"), "--groups: Groups must be a power of two up to 4, not 8"),
    (("-P", "memsys.own_patches=16"), "A job must be of one phase whose patches every cluster holds")])
def test_wrong_machines_are_refused(words, message):
    done = run(*SMALL, *words)
    assert done.exit_code
    assert message in str(done.exception) + done.output


def test_more_clusters_take_fewer_cycles_until_something_limits_them(casts):
    machine = EngineMachine(SPEC, PRESETS["paper"], folder=casts)
    (one,), four = (strong_runs(machine, nodes, frusta=4) for nodes in (1, 4))
    assert one.cycles > four[0].cycles
    assert four[0].cycles > one.bounds["casts"] // 4
    assert {each.groups for each in four} == {4, 2, 1}
    assert four == sorted(four, key=lambda run: run.cycles)


def test_weak_scaling_has_a_frustum_for_each_cluster():
    runs = [weak_run(SPEC, PRESETS["paper"], nodes) for nodes in (1, 2)]
    assert [len(each.prepared.records) for each in runs] == [1, 2]
    assert runs[1].cycles < 1.3 * runs[0].cycles


@pytest.mark.parametrize(("nodes", "frusta", "groups"), [
    (1, 1, 1), (16, 1, 1), (16, 3, 2), (16, 4, 4), (16, 15, 8), (16, 16, 16), (16, 17, 16), (4, 64, 4), (64, 63, 32)])
def test_by_default_each_cluster_is_a_group_as_far_as_there_are_frusta(monkeypatch, nodes, frusta, groups):
    """A power of two of them; without a frustum a group would idle."""
    found = []

    class Machine:
        def __init__(self, *_, **options):
            pass

        def run(self, nodes, groups, **options):
            found.append((nodes, groups))
            raise SystemExit

    monkeypatch.setattr("radiosity.machines.engine.engine_machine.EngineMachine", Machine)
    run("cornell", "--nodes", str(nodes), "--frusta", str(frusta))
    assert found == [(nodes, groups)]


def test_divisions_have_no_more_groups_than_frusta():
    assert divisions(4, 64) == [4, 2, 1]
    assert divisions(256, 64) == [64, 32, 16]
    assert divisions(4096, 64) == [256]
