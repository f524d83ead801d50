"""What is printed about view factors, and which attempts a time limit allows: all figures differ."""

from types import SimpleNamespace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.grid import Grid
from golden.light.factors.receivers import ReceiverFactors
from golden.light.factors.view_factors import ViewFactors
from radiosity.tasks import view_factors
from radiosity.tasks.view_factors import ViewFactorTask
from tb.golden.light.factors.samples import three_sides

FOOT = 0.3048
FACTORS = three_sides(back=np.array([0.04, 0, 0.02]), unprojected_sky=np.array([0.09, 0, 0]), weight_bits=3,
                      row_sums=np.array([[3, 4], [4, 4], [4, 2]]), settings={"error": 0.0125, "sky_error": 0.005})


class Rows:
    """What would be computed."""

    def __init__(self, block_rows=4, **settings):
        self.block_rows, self.settings = block_rows, settings

    def __len__(self):
        return 3


@pytest.fixture
def seconds(monkeypatch):
    """The seconds that the attempts take, of which each has an error; their results are made up."""
    clock, taken = [0.0], {}

    def compute(rows, **options):
        clock[0] += taken.setdefault(rows if isinstance(rows, float) else None, 1)
        return FACTORS

    monkeypatch.setattr(view_factors, "time", SimpleNamespace(perf_counter=lambda: clock[0]))
    monkeypatch.setattr(view_factors, "compute_view_factors", compute)
    return taken


def test_every_figure_of_the_report(seconds, tmp_path):
    task = ViewFactorTask("furnace:1", tmp_path / "a.npz", unit="ft")
    report, text = task.run(Rows(), SimpleNamespace(remove=lambda: None), method="grid")
    assert report == {
        "output": tmp_path / "a.npz", "scene": "furnace:1", "method": "grid", "patches": 3, "entries": 6,
        "closure": pytest.approx(0.02), "reciprocity": pytest.approx(FACTORS.reciprocity, abs=1e-12), "seconds": 1,
        "error": pytest.approx(0.015), "sky_error": pytest.approx(0.02), "sky_patch_error": pytest.approx(0.006),
        "largest_absent": pytest.approx(0.00625), "largest_change": pytest.approx(0.0075),
        "sky_change": pytest.approx(0.03), "infeasible": [2], "missed": [1], "sky_missed": [0, 1], "back": 0.04,
        "area": pytest.approx(12 * FOOT**2), "length": pytest.approx(FOOT),
        "peak_memory": report["peak_memory"], "least_share": 2 / 8, "greatest_share": 4 / 8}
    for line in ("area 1.115 m2 in a scene 0.3048 m long: its unit of length is taken as ft (--unit)",
                 "estimated error 1.5e-02, of the sky 2.0e-02; the projection moves factors by up to 7.5e-03, the sky "
                 "by up to 3.0e-02",
                 "a factor between patches that face each other and that has no entry may be up to 6.3e-03",
                 "estimated error of a patch of the sky 6.0e-03",
                 "rows that do not close within their errors: 1, the first 2: their sums are off by up to 2.0e-02; "
                 "uncut crossings and overlaps of patches do this, and a smaller --error may close them",
                 "rows that miss the requested error: 1, the first 1: they have the most segments that a pair may "
                 "have, and their errors are in the file; smaller patches (--max-edge) have smaller errors",
                 "rows that miss the requested error of the sky: 2, the first 0, 1: they have the most rays that a "
                 "patch may have, and their errors are in the file",
                 "hemispheres met a patch in 25.00% to 50.00%"):
        assert line in text.splitlines()
    np.testing.assert_allclose(ViewFactors.open(tmp_path / "a.npz").area, FACTORS.area * FOOT**2)


@pytest.mark.parametrize("way", ["run", "run_within"])
def test_factors_between_surfaces_are_written_beside(seconds, tmp_path, way):
    """Areas are in m2 there too."""
    task = ViewFactorTask("furnace:1", tmp_path / "a.npz", surfaces=tmp_path / "s.nc", unit="ft")
    report, text = task.run(Rows(), SimpleNamespace(remove=lambda: None), method="grid") if way == "run" else (
        task.run_within(1, lambda error: error, error=0.1, method="grid"))
    assert (report["surfaces"], report["surfaces_output"]) == (3, tmp_path / "s.nc")
    assert f"{tmp_path / 's.nc'}: 3 surfaces" in text.splitlines()
    found = ViewFactors.open(tmp_path / "s.nc")
    assert found.surface.tolist() == [" (back)", "Wand süd", "sun"]
    np.testing.assert_allclose(found.area, [5 * FOOT**2, 4 * FOOT**2, 3 * FOOT**2])


def test_receivers_are_written_to_their_table(monkeypatch, tmp_path):
    """What the caster gives for each point is made up."""
    (tmp_path / "p.txt").write_text("1 2 3 0 0 1\n")
    task = ViewFactorTask("furnace:1", tmp_path / "a.npz", receivers=(tmp_path / "p.txt", tmp_path / "r.csv"))
    found = ReceiverFactors(names=["wall"], share=np.array([[0.25, 0.75, 0]]), error=np.array([[0.02, 0.03, 0.001]]))
    given = {}
    monkeypatch.setattr(view_factors, "receiver_factors", lambda scene, caster, points, **options: given.update(
        options, scene=scene, caster=caster, at=points.position.tolist()) or found)
    figures, text = task.receive("caster", error=0.07, seed=5)
    assert given == {"scene": task.scene, "caster": "caster", "at": [[1, 2, 3]], "error": 0.07, "seed": 5}
    assert figures == {"receivers": 1, "receivers_output": tmp_path / "r.csv", "receivers_error": 0.06}
    assert text == f"\n{tmp_path / 'r.csv'}: 1 receiver, estimated error 6.0e-02"
    assert (tmp_path / "r.csv").read_text().splitlines()[1:] == ["0,wall,0.25,0.02", "0,(sky),0.75,0.03"]
    assert ViewFactorTask("furnace:1", tmp_path / "a.npz").receive("caster", error=0.07, seed=5) == ({}, "")


def test_a_scene_that_repeats_is_computed_with_its_copies(seconds, tmp_path):
    """A flat square of side 1, whose copies are one tile around it."""
    (tmp_path / "a.vs3").write_text("V 1 0 0 0\nV 2 1 0 0\nV 3 1 1 0\nV 4 0 1 0\nS 1 1 2 3 4 0 0 1 road\n")
    task = ViewFactorTask(str(tmp_path / "a.vs3"), tmp_path / "a.npz", period=(2.0, 3.0))
    assert len(task.scene) == 9
    assert len(task.rows(Grid(task.scene), error=0.1)) == 1
    report, text = task.run(Rows(), SimpleNamespace(remove=lambda: None), method="grid")
    assert report["length"] == 1
    for line in ("the scene repeats: a patch counts with those in all 9 tiles; what leaves them counts as sky",
                 "zenith +z, as VS3 files have it (--zenith)"):
        assert line in text.splitlines()
    alone = ViewFactorTask(str(tmp_path / "a.vs3"), tmp_path / "a.npz")
    assert (len(alone.scene), len(alone.rows(Grid(alone.scene), error=0.1))) == (1, 1)


@pytest.mark.parametrize(("surfaces", "message"), [
    ("s.txt", r"Name must end in \.csv or \.npz or \.nc"), ("none/s.csv", "cannot be written"),
    ("a.npz", "named twice")])
def test_a_file_of_surfaces_is_checked_before_the_work(tmp_path, surfaces, message):
    with pytest.raises(InputError, match=message):
        ViewFactorTask("furnace:1", tmp_path / "a.npz", surfaces=tmp_path / surfaces)


@pytest.mark.parametrize(("options", "lines"), [
    ({}, []), ({"has_sky_patches": True}, ["zenith +y, that of the scene (--zenith)"]),
    ({"has_sky_patches": True, "zenith": (0, 0, 1)}, ["zenith +z, as given"])])
def test_the_zenith_of_patches_of_the_sky_is_said(seconds, tmp_path, options, lines):
    task = ViewFactorTask("cornell", tmp_path / "a.npz", **options)
    _, text = task.run(Rows(), SimpleNamespace(remove=lambda: None), method="grid")
    assert [line for line in text.splitlines() if line.startswith("zenith")] == lines


@pytest.mark.parametrize(("suffix", "missing"), [("npz", False), ("nc", False), ("inp", True)])
def test_files_that_leave_out_backs_are_said_to(seconds, tmp_path, suffix, missing):
    task = ViewFactorTask("furnace:1", tmp_path / f"vfsparse.{suffix}")
    _, text = task.run(Rows(), SimpleNamespace(remove=lambda: None), method="grid")
    assert "black backs of one-sided patches take up to 0.04 of a row" in text
    assert ("these files leave out" in text) == missing


@pytest.mark.parametrize(("error", "limit", "attempts"), [
    (0.1, 1, [0.1]), (0.02, 99, [0.05, 0.02]), (1e-3, 8.9, [0.05]), (1e-3, 9, [0.05, 0.0125]),
    (1e-3, 19, [0.05, 0.0125, 0.003125]), (1e-3, 999, [0.05, 0.0125, 0.003125, 1e-3])])
def test_a_time_limit_allows_eight_times_the_last_attempt(seconds, tmp_path, error, limit, attempts):
    """The second attempt takes 2 s and ends after 3 s, so a third one needs a limit of 3 + 8 x 2 s."""
    seconds |= {0.05: 1, 0.0125: 2, 0.003125: 10}
    task = ViewFactorTask("furnace:1", tmp_path / "a.npz", unit="ft")
    tried = []
    _, text = task.run_within(limit, lambda error: tried.append(error) or error, error=error, method="grid")
    assert tried == attempts
    assert ("the time limit ended the work" in text) == (attempts[-1] > error)
    np.testing.assert_allclose(ViewFactors.open(tmp_path / "a.npz").area, FACTORS.area * FOOT**2)


@pytest.mark.parametrize("change", [
    {"scene": "furnace:2"}, {"method": "naive"}, {"block_rows": 8}, {"error": 0.01}, {"seed": 1}])
def test_blocks_of_other_work_are_refused(tmp_path, change):
    def store(scene="furnace:1", method="grid", **settings):
        task = ViewFactorTask(scene, tmp_path / "a.npz")
        return task.store(Rows(**{"error": 0.02, "seed": 0} | settings), method=method, resume=True)

    store().save(0, SimpleNamespace(rows=np.zeros(1)))
    store()
    with pytest.raises(InputError, match=f"the unfinished run had other values of {', '.join(change)}$"):
        store(**change)


def test_a_limit_of_the_area_alone_cuts_patches(tmp_path):
    assert len(ViewFactorTask("furnace:1", tmp_path / "a.npz", max_area=0.3).scene) == 24
    assert len(ViewFactorTask("furnace:1", tmp_path / "a.npz", max_edge=0.6).scene) == 24
