"""The ``schedule`` command: what it prints and writes, and what it refuses."""

import numpy as np
import pytest
from PIL import Image

from golden.engine.memory_map import from_bytes
from tb.radiosity.cli.golden.runner import report, run

SCENE = ("schedule", "lobby", "--rays", "64x16", "--ratio", "16", "--clusters", "4")


@pytest.fixture(scope="module")
def printed():
    return report(*SCENE)


def test_the_report_adds_up(printed):
    clusters = printed["clusters"]
    assert sum(cluster["rays"] for cluster in clusters) == 1024
    assert sum(cluster["resident"] for cluster in clusters) == printed["resident"] == printed["found"]
    tests = [cluster["tests"] for cluster in clusters]
    assert printed["balance"]["true"] == pytest.approx(max(tests) / np.mean(tests))
    estimated = [cluster["estimated_tests"] for cluster in clusters]
    assert printed["balance"]["estimated"] == pytest.approx(max(estimated) / np.mean(estimated))
    assert list(printed["cuf"]) == ["1", "4", "7", "10", "13"]
    assert all(0 < printed["cuf"][point] <= printed["effectiveness"][point] <= 1 for point in printed["cuf"])


def test_limits_hold():
    printed = report(*SCENE, "--ray-capacity", 300, "--capacity", 5)
    assert max(cluster["rays"] for cluster in printed["clusters"]) <= 300
    assert max(cluster["resident"] for cluster in printed["clusters"]) <= 5
    assert printed["resident"] < printed["found"]


def test_a_given_point_serves_itself_only():
    printed = report(*SCENE, "--origin", "3,3,2", "--normal", "1,0,0", "--topology", "ring")
    assert list(printed["cuf"]) == ["1"]
    assert printed["mean_hops"] >= 1
    assert sorted(cluster["processor"] for cluster in printed["clusters"]) == [0, 1, 2, 3]


def test_image_and_picture_are_written(printed, tmp_path):
    assert run(*SCENE, "-o", tmp_path / "a.bin", "--picture", tmp_path / "a.png").exit_code == 0
    image = from_bytes((tmp_path / "a.bin").read_bytes())
    assert [int(cluster["residents"]) for cluster in image["clusters"]] == [
        cluster["resident"] for cluster in printed["clusters"]]
    assert int(image["rows"]["weight"].sum()) * 64 == 1 << 32
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.size == (1024, 256)


@pytest.mark.parametrize(("arguments", "message"), [
    (("--clusters", 3), "Clusters must be a power of two, not 3"),
    (("--ratio", 5), "Ratio must be a power of two, not 5"),
    (("--ratio", 4096), "Ratio must leave a ray of 64 x 16"),
    (("--ray-capacity", 100), "the capacity is 100"),
    (("--origin", "1,1,1"), "--origin and --normal must be given together"),
    (("-o", "image.png"), "Name must end in .bin"),
    (("--picture", "map.bin"), "Name must end in .png"),
])
def test_what_cannot_be_scheduled_is_one_line_and_code_2(arguments, message):
    result = run(*SCENE, *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert len(result.stderr.splitlines()) == 1
