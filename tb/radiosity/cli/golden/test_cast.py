"""The ``cast`` command: what it prints and writes, and what it refuses."""

import numpy as np
import pytest
from PIL import Image

import radiosity.tasks.cast
from golden.cast.default_camera import default_camera
from golden.cast.grid import Grid
from golden.cast.screen import Screen
from golden.scene.open import open_scene
from tb.radiosity.cli.golden.runner import report, run

FRUSTUM = ("cast", "cornell", "--patch", "2", "--rays", "32x8")


def test_the_report_counts_the_work_and_finds_no_difference():
    printed = report(*FRUSTUM, "--compare", "naive,oracle")
    assert printed["rays"] == 256
    assert printed["naive"] == {"differences": 0}
    assert printed["oracle"]["unexplained"] == 0
    assert printed["patches"] > 0
    assert printed["edrc"] == pytest.approx(printed["tests_per_ray"] * 256 / printed["patches"])
    assert printed["tests_per_ray"] <= printed["in_windows_per_ray"]


def test_the_text_says_the_same_as_the_json():
    printed, text = report(*FRUSTUM, "--compare", "naive"), run(*FRUSTUM, "--compare", "naive").stdout
    assert f"{printed['hits']} of 256 rays hit" in text
    assert f"{printed['tests_per_ray']:.2f} tests" in text
    assert f"{printed['shells']} shells" in text
    assert "naive: 0 differences" in text


def test_method_clusters_and_cell_size_change_the_work_but_not_the_hits(tmp_path):
    files = []
    for number, arguments in enumerate((("--method", "naive"), ("--clusters", 4), ("--cell", 0.25))):
        files.append(tmp_path / f"{number}.npz")
        assert run(*FRUSTUM, "-o", files[-1], *arguments).exit_code == 0
    with np.load(files[0]) as first:
        for path in files[1:]:
            with np.load(path) as other:
                for name in first.files:
                    np.testing.assert_array_equal(first[name], other[name])


def test_clusters_are_counted_one_by_one():
    clusters = report(*FRUSTUM, "--clusters", 4)["clusters"]
    assert sum(cluster["rays"] for cluster in clusters) == 256
    assert all(cluster["tests"] > 0 for cluster in clusters)


def test_distances_in_the_file_are_in_scene_units(tmp_path):
    path = tmp_path / "hits.npz"
    for frustum in (("--origin", "0.5,0.5,0.25", "--normal", "0,0,-3"), ("--screen", "9x7")):
        assert run("cast", "furnace:1", *frustum, "-o", path).exit_code == 0
        with np.load(path) as hits:
            assert (hits["patch"] >= 0).all()
            longest = np.sqrt(3) if frustum[0] == "--origin" else 4
            assert 0.2 < hits["t"].min() < hits["t"].max() < longest
            if frustum[0] == "--origin":
                assert hits["t"].min() == pytest.approx(0.25, rel=1e-3)


def test_distances_of_a_screen_are_depths(tmp_path):
    scene, path = open_scene("furnace:1"), tmp_path / "hits.npz"
    assert run("cast", "furnace:1", "--screen", "9x7", "-o", path).exit_code == 0
    expected = Grid(scene).nearest(Screen(camera=default_camera(scene), width=9, height=7).rays())
    with np.load(path) as hits:
        np.testing.assert_allclose(hits["t"], expected.t, rtol=1e-3)


def test_the_picture_has_a_colour_for_each_patch(tmp_path):
    path, hits = tmp_path / "picture.png", tmp_path / "hits.npz"
    assert run(*FRUSTUM, "--picture", path, "-o", hits).exit_code == 0
    pixels = np.asarray(Image.open(path)).reshape(-1, 3)
    with np.load(hits) as arrays:
        patch = arrays["patch"]
    assert len(pixels) == 256
    colours = {number: {tuple(colour) for colour in pixels[patch == number].tolist()} for number in np.unique(patch)}
    assert all(len(colour) == 1 for colour in colours.values())
    assert len(set.union(*colours.values())) == len(colours)


@pytest.mark.parametrize(("arguments", "says"), [
    ((), "none"), (("--patch", 1, "--screen", "4x4"), "--patch and --screen"), (("--origin", "1,1,1"), "together"),
    (("--patch", 9999), "Patch must be"), (("--patch", -1), "Patch must be"),
    (("--patch", 1, "--rays", "30x8"), "power of two"), (("--patch", 1, "--clusters", 3), "Clusters"),
    (("--patch", 1, "--cell", 2), "Cell size"), (("--patch", 1, "--compare", "naive,me"), "'me'"),
    (("--patch", 1, "-P", "icu.rays=64"), "icu.rays"), (("--patch", 1, "-o", "a.txt"), "a.txt"),
    (("--origin", "1,1,1", "--normal", "0,0,0"), "Normal"), (("--patch", 1, "--picture", "a.jpg"), "a.jpg")])
def test_what_cannot_be_cast_is_one_line(arguments, says):
    result = run("cast", "cornell", *arguments)
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1
    assert says in result.stderr


@pytest.mark.parametrize("reference", ["naive", "oracle"])
def test_the_exit_code_reports_a_wrong_hit(monkeypatch, reference):
    right = radiosity.tasks.cast.Shelling.cast

    def wrong(*arguments):
        hits, counts = right(*arguments)
        hits.patch[40:90] = (hits.patch[40:90] + 3) % 7
        return hits, counts

    monkeypatch.setattr(radiosity.tasks.cast.Shelling, "cast", wrong)
    assert run(*FRUSTUM, "--compare", reference).exit_code == 1


SHADOWS = ("cast", "cornell", "--kind", "shadow", "--patch", "0")


def test_a_point_of_a_light_sees_what_double_precision_says():
    scene = open_scene("cornell")
    middles = Grid(scene).occluded(np.repeat(scene.centres[:1], len(scene), axis=0), scene.centres, np.stack(
        [np.full(len(scene), scene.surface[0]), scene.surface], axis=1))
    printed = report(*SHADOWS, "--compare", "naive")
    assert 0 < printed["visible"] < printed["rays"] == len(scene)
    assert printed["visible"] == len(scene) - middles.sum()
    assert printed["naive"] == {"differences": 0}
    text = run(*SHADOWS).stdout
    assert text.startswith(f"{printed['visible']} of {len(scene)} points are visible, {printed['tests_per_ray']:.2f} ")


def test_shadow_rays_have_a_bit_for_each_target_whoever_casts(tmp_path):
    """In an empty room; the last target is the light's very point."""
    scene = open_scene("furnace:1")
    (tmp_path / "targets.txt").write_text("plane 0.1 0.1 0.5  0.8 0 0  0 0.8 0  20 20\n0.5 0.5 0.25 0 0 1\n")
    given = ("cast", "furnace:1", "--kind", "shadow", "--origin", "0.5,0.5,0.25", "--targets", tmp_path / "targets.txt")
    files = []
    for number, method in enumerate((("--method", "naive"), ("--cell", 0.5), ("--cell", 0.1))):
        files.append(tmp_path / f"{number}.npz")
        assert run(*given, "-o", files[-1], *method).exit_code == 0
    assert len({path.read_bytes() for path in files}) == 1
    with np.load(files[0]) as found:
        assert found.files == ["visible"]
        assert found["visible"].tolist() == [True] * 401
    assert report("cast", "furnace:1", "--kind", "shadow", "--origin", "0.5,0.5,0.25")["visible"] == len(scene)


@pytest.mark.parametrize(("words", "says"), [
    (("--kind", "shadow"), "one of --origin and --patch must be given, not none"),
    (("--kind", "shadow", "--origin", "1,1,1", "--patch", "0"), "not both"),
    (("--kind", "shadow", "--patch", "99"), "Patch must be 0 to 19, not 99"),
    (("--kind", "shadow", "--patch", "0", "--targets", "nowhere.txt"), "nowhere.txt: cannot be read"),
    (("--kind", "shadow", "--patch", "0", "--normal", "0,0,1"), "--normal does not go with --kind shadow"),
    (("--kind", "shadow", "--patch", "0", "--clusters", "2"), "--clusters of --kind shadow needs --method machine"),
    (("--kind", "shadow", "--patch", "0", "--compare", "oracle"), "--compare oracle does not go with --kind shadow"),
    (("--kind", "shadow", "--patch", "0", "-P", "numbers.vector_fraction=21"), "Number formats (numbers.*) must be"),
    (("--kind", "screen", "--patch", "0"), "--patch does not go with --kind screen"),
    (("--patch", "0", "--targets", "a.txt"), "--targets needs --kind shadow"),
    (("--screen", "8x8", "--rays", "256x64"), "--rays does not go with --screen"),
    (("--patch", "0", "--method", "naive", "--clusters", "1"), "--clusters does not go with --method naive"),
    (("--patch", "0", "--method", "naive", "--cell", "0.25"), "--cell: Cell size must be left out with method naive"),
    (("--kind", "shadow", "--patch", "0", "--method", "naive", "--cell", "0.25"), "must be left out with method naive"),
])
def test_options_of_another_kind_are_one_line(words, says):
    result = run("cast", "cornell", *words)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert says in result.stderr
