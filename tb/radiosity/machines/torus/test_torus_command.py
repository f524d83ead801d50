"""Rays that travel on a torus are simulated by a command, and its benchmark grades the source's tables."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import radiosity.cli.main
from benchmarks.torus import OPTIMA, PASSED, SPEEDUPS, grade_count, percentile, sweep
from radiosity.cli.golden import choices
from radiosity.machines.torus.node_boxes import GROWTHS
from radiosity.machines.torus.torus_run import STORAGES, TorusSetup, simulate_torus
from radiosity.machines.torus.torus_scenes import TORUS_SCENES
from radiosity.machines.torus.torus_steps import steps_figure
from tb.radiosity.charts import rectangles

pytestmark = [pytest.mark.xdist_group("machines"), pytest.mark.usefixtures("interpreted")]

SMALL = ("spheres40", "--size", "20x24", "--voxels", "5")


def run(*words):
    return CliRunner().invoke(radiosity.cli.main.main, ["machine", "torus", *words])


def test_the_command_prints_one_object_with_one_hash_for_all_machines():
    reports = [json.loads(run(*SMALL, *more, "--json").output) for more in (
        ("--nodes", "1"), ("--nodes", "9", "--delay", "5000"), ("--nodes", "4", "--storage", "hash", "--no-steal"))]
    assert {"scene", "seconds", "efficiency", "traffic", "visits", "of_a_node", "picture"} <= reports[0].keys()
    assert len({one["picture"] for one in reports}) == 1
    assert len({one["rays"] for one in reports}) == 1
    assert (reports[1]["nodes"], reports[1]["rows"], reports[1]["columns"]) == (9, 20, 24)
    assert json.loads(run(*SMALL, "--no-shadows", "--json").output)["shadow_rays"] == 0
    assert json.loads(run(*SMALL, "--seed", "3", "--json").output)["picture"] != reports[0]["picture"]


def test_scenes_of_patches_have_the_same_picture_on_all_machines_too(tmp_path):
    file = tmp_path / "picture.png"
    one, many = (run("cornell", "--size", "12x12", "--nodes", nodes, "-o", str(file), "--json")
                 for nodes in ("1", "16"))
    assert json.loads(one.output)["picture"] == json.loads(many.output)["picture"]
    with Image.open(file) as picture:
        assert picture.size == (12, 12)


def test_text_has_rays_messages_and_loads():
    output = run(*SMALL, "--nodes", "4").output
    assert "4 nodes, 5 voxels along each axis" in output
    assert "rays passed" in output
    assert "walks of a node: " in output


def test_steps_have_a_bar_for_each_walk():
    done = simulate_torus(TORUS_SCENES["spheres40"](), TorusSetup(nodes=4, size=(6, 6), subdivisions=4), log=50)
    bars = np.concatenate([rectangles(patch) for patch in steps_figure(done).axes[0].patches])
    assert len(bars) == len(done.log) == 50
    np.testing.assert_allclose(sorted((bars[:, 1] - bars[:, 0]) * 1e6), sorted(done.log[:, 1]), atol=1)
    assert {int(lane) for lane in bars[:, 2]} == set(done.log[:, 2].tolist()) == set(range(4))


@pytest.mark.parametrize(("words", "message"), [
    (("--nodes", "12"), "--nodes: Nodes must be a square number up to 1024, not 12"),
    (("--nodes", "1024"), "Pixels must be at least 32 in a row and in a column, not 20"),
    (("--voxels", "0"), "--voxels: Subdivisions must be 1 to 128, not 0"),
    (("--growth", "-1"), "--growth: Growth must be 0 to 100 times the box, not -1.0"),
    (("--buffer", "20"), "--buffer: Buffer must be 340 to"),
    (("--delay", "-1"), "--delay: Delay must be 0 to"),
    (("--seed", "-1"), "--seed: Seed must be 0 to")])
def test_wrong_machines_are_refused(words, message, tmp_path):
    file = tmp_path / "steps.svg"
    done = run(*SMALL, *words, "--steps", str(file))
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert message in done.stderr
    assert not file.exists()


@pytest.mark.parametrize(("picture", "steps", "message"), [
    ("picture.jpg", "steps.svg", "Name must end in .png, not '.jpg'"),
    ("picture.png", "steps.png", "Name must end in .svg, not '.png'"),
    ("picture.png", "missing/steps.svg", "cannot be written (No such file or directory)")])
def test_wrong_outputs_are_refused_before_any_is_written(tmp_path, picture, steps, message):
    done = run(*SMALL, "-o", str(tmp_path / picture), "--steps", str(tmp_path / steps))
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert message in done.stderr
    assert not list(tmp_path.iterdir())


def test_options_have_the_names_of_their_registries():
    assert choices.TORUS_GROWTHS == GROWTHS
    assert choices.TORUS_STORAGES == STORAGES


def test_scenes_have_the_source_s_numbers_of_objects_whatever_the_seed():
    for name, count in {"spheres40": 40, "barroom367": 367, "face954": 954}.items():
        scenes = [TORUS_SCENES[name](seed) for seed in (0, 0, 1)]
        assert [len(one) for one in scenes] == [count] * 3
        assert (scenes[0].corners == scenes[1].corners).all()
        assert not (scenes[0].corners == scenes[2].corners).all()
        assert ((scenes[0].counts == 0).all()) == (name == "spheres40")


def test_the_best_grid_is_neither_a_single_voxel_nor_the_finest_for_spheres():
    best, tests, ratio = sweep("spheres40", 0, (10, 10), (1, 9, 97))
    assert best == 9
    assert tests < 4
    assert ratio > 1.3


def test_figures_are_graded_and_lie_at_percentiles():
    assert [grade_count(one, 100) for one in (90, 115, 180, 60, 210)] == [
        "reproduced", "reproduced", "same shape", "same shape", "not reproduced"]
    assert grade_count(9, 5, slack=4) == "reproduced"
    assert [percentile([1, 2, 3, 4], one) for one in (0, 2, 2.5, 9)] == ["0 %", "38 %", "50 %", "100 %"]
    assert OPTIMA.keys() == {name for name, _ in SPEEDUPS} == TORUS_SCENES.keys()
    assert PASSED[0.24][1] / PASSED[0.02][1] == pytest.approx(0.656, abs=1e-3)


@pytest.mark.nightly
def test_1024_nodes_trace_a_million_rays():
    report = json.loads(run("spheres40", "--size", "760x760", "--nodes", "1024", "--voxels", "8", "--json").output)
    assert report["nodes"] == 1024
    assert report["rays"] >= 1_000_000
