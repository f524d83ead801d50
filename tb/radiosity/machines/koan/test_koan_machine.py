"""Shared pages are simulated by commands, and closed forms of the source's times are as near as they are said to be."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import radiosity.cli.main
from benchmarks.koan import fit, saturation
from benchmarks.koan_scenes import KOAN_SCENES, koan_scene
from benchmarks.koan_times import TABLE_3, TABLE_4, closed_3, closed_4, errors
from radiosity.cli.golden import choices
from radiosity.machines.koan.koan_machine import KoanMachine
from radiosity.machines.koan.page_chart import holders
from radiosity.machines.koan.page_state import INVALIDATED, READ, WRITE
from radiosity.machines.koan.pixel_items import SCHEDULES

pytestmark = pytest.mark.xdist_group("machines")

SMALL = ("cornell", "--size", "24x24", "--page", "256")


def run(*words):
    return CliRunner().invoke(radiosity.cli.main.main, ["machine", "koan", *words])


def test_the_command_prints_one_object():
    reports = [json.loads(run(*SMALL, "--json", *more).output) for more in (
        ("--nodes", "1"), ("--nodes", "8"), ("--nodes", "4", "--schedule", "scattered", "--cache", "2048"),
        ("--nodes", "4", "--item", "1", "--offload"))]
    assert {"scene", "seconds", "efficiency", "traffic", "faults", "of_a_node", "picture"} <= reports[0].keys()
    assert len({one["picture"] for one in reports}) == 1
    assert [one["nodes"] for one in reports] == [1, 8, 4, 4]
    assert reports[0]["faults"] == 0 < reports[1]["faults"]
    assert reports[2]["drops"] > 0
    assert reports[3]["items"] == 24 * 24
    assert reports[3]["of_a_node"]["interrupted_milliseconds"]["most"] == 0


def test_radiosity_in_shared_pages_does_not_depend_on_the_nodes():
    reports = [json.loads(run("cornell", "--radiosity", "16x8", "--nodes", nodes, "--json").output)
               for nodes in ("1", "8")]
    assert (reports[0]["F"], reports[0]["radiosity"]) == (reports[1]["F"], reports[1]["radiosity"])
    assert reports[1]["solution"]["invalidations"] > 0
    assert "Gauss-Jacobi" in run("cornell", "--radiosity", "16x8", "--nodes", "4").output


def test_a_run_writes_its_picture_and_a_chart(tmp_path):
    picture, chart = tmp_path / "one.png", tmp_path / "pages.svg"
    output = run(*SMALL, "--nodes", "4", "-o", str(picture), "--pages", str(chart)).output
    assert "24 x 24 pixels" in output
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert chart.read_text().count(" copies</text>") == 6


def test_holders_follow_the_log():
    log = np.array([(10, 1, 0, READ), (20, 0, 0, INVALIDATED), (30, 1, 0, WRITE)])
    assert holders(log, 2, 2, np.array([0, 10, 25])).tolist() == [
        [[True, False], [False, True]], [[True, True], [False, True]], [[False, True], [False, True]]]


@pytest.mark.parametrize(("words", "message"), [
    (("--nodes", "12"), "--nodes: Nodes must be a power of two up to 1024, not 12"),
    (("--page", "300"), "--page: Page bytes must be a power of two from 128, not 300"),
    (("--cache", "100"), "--cache: Cache must be at least one page, not 0 pages"),
    (("--item", "0"), "--item: Item must be at least 1 pixel along its side, not 0"),
    (("--size", "0x24"), "--size: Width must be 1 to 8192, not 0"),
    (("--size", "24x99999"), "--size: Height must be 1 to 8192, not 99999"),
    (("--nodes", "1024"), "--size: Size must be at least 32x32 for 1024 nodes, not 24x24"),
    (("--radiosity", "16x8"), "--size does not go with --radiosity")])
def test_wrong_machines_are_refused(words, message):
    done = run(*SMALL, *words)
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert message in done.stderr


def test_options_have_the_names_of_their_registry():
    assert choices.KOAN_SCHEDULES == SCHEDULES


@pytest.mark.parametrize("name", ["Teapot", "Mountain"])
def test_closed_forms_are_near_the_source_and_need_their_faults(name):
    def largest(table, form):
        return max(map(abs, errors(table[name], {nodes: form(nodes) for nodes in table[name]}).values()))

    assert largest(TABLE_4, lambda nodes: closed_4(name, nodes)) <= 0.0024
    assert largest(TABLE_3, lambda nodes: closed_3(name, nodes)) <= 0.01
    assert largest(TABLE_3, lambda nodes: TABLE_3[name][1] / nodes) > 0.05


def test_times_without_faults_are_1_7_percent_off():
    assert errors(TABLE_4["Mountain"], {nodes: closed_4("Mountain", nodes, 0) for nodes in TABLE_4["Mountain"]})[
        32] == pytest.approx(-0.017, abs=0.001)


def test_a_fit_finds_the_numbers_that_made_the_times():
    def seconds(numbers):
        return {nodes: 100 / nodes + numbers[0] * (nodes - 1) / nodes + numbers[1] for nodes in (2, 4, 8)}

    made = {1: 100, **seconds((0.3, 0.02))}
    assert fit(seconds, made, [(0, 0), (1, 0), (0, 1)]) == pytest.approx([0.3, 0.02])


def test_saturation_is_where_efficiency_is_one_half():
    assert saturation({100: 0.25, 200: 0.5, 400: 0.9}) == pytest.approx(200)
    assert 100 < saturation({100: 0.3, 200: 0.6}) < 200
    assert saturation({100: 0.7, 200: 0.9}) == 0
    assert saturation({100: 0.1, 200: 0.4}) == np.inf


def test_stand_ins_have_the_lights_of_their_databases_and_about_as_many_polygons():
    for name in ("Teapot", "Mountain"):
        scene = koan_scene(name)
        assert len(scene.lights) == KOAN_SCENES[name].lights
        assert not scene.channels("emission").any()
        assert abs(len(scene) / KOAN_SCENES[name].polygons - 1) < 0.06


@pytest.mark.nightly
def test_1024_nodes_trace_a_million_rays():
    found = KoanMachine(koan_scene("Teapot"), size=(576, 576)).run(nodes=1024)
    assert found.nodes == 1024
    assert (found.times.node >= 0).all()
