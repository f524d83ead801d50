"""`formfactors` on a disk that is full, and within a time limit."""

import json
import resource
from contextlib import contextmanager, nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.closed_forms import c_11
from golden.cast import shared_caster
from golden.light.factors.view_factors import ViewFactors
from tb.radiosity.cli.golden.runner import report, run

SCENE = "furnace:6", "--rays", "64x16"


@contextmanager
def full_disk(size):
    """Files may have so many bytes, as if no more were left."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["F.npz", "F.nc", "vfsparse.inp.1"])
def test_a_full_disk_ends_in_one_line_and_leaves_the_old_files(folder, name):
    whole = run("formfactors", *SCENE, "-o", name)
    assert whole.exit_code == 0, whole.stderr
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with full_disk(max(map(len, before.values())) - 1000):
        failed = run("formfactors", *SCENE, "--samples", "2", "-o", name)
    assert failed.exit_code == 2
    assert failed.stderr.startswith("error: ")
    assert failed.stderr.count("\n") == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_a_full_disk_leaves_no_library_without_its_scene(folder):
    with full_disk(600):
        failed = run("scene", "cornell", "-o", "a.obj")
    assert failed.exit_code == 2
    assert not list(folder.iterdir())


def test_a_run_that_met_a_full_disk_is_continued(folder):
    assert run("formfactors", *SCENE, "-o", "whole.npz").exit_code == 0
    size = (folder / "whole.npz").stat().st_size
    with full_disk(size // 2):
        assert run("formfactors", *SCENE, "-o", "F.npz").exit_code == 2
    assert not (folder / "F.npz").exists()
    continued = run("formfactors", *SCENE, "-o", "F.npz", "--resume")
    assert continued.exit_code == 0, continued.stderr
    assert (folder / "F.npz").read_bytes() == (folder / "whole.npz").read_bytes()
    assert [path.name for path in sorted(folder.iterdir())] == ["F.npz", "whole.npz"]


def test_a_run_whose_output_fails_at_the_end_keeps_all_its_blocks(folder, monkeypatch):
    """The one that continues it casts nothing."""
    assert run("formfactors", *SCENE, "-o", "whole.npz").exit_code == 0

    def fails(*_):
        raise OSError(28, "No space left on device", "F.npz")

    with monkeypatch.context() as full:
        full.setattr("radiosity.tasks.view_factors.write_view_factors", fails)
        failed = run("formfactors", *SCENE, "-o", "F.npz")
    assert (failed.exit_code, failed.stderr.count("\n")) == (2, 1)
    # 216 rows in blocks of 64.
    assert len([*(folder / "F.npz.blocks").glob("rows-*.npz")]) == 4
    with monkeypatch.context() as idle:
        idle.setattr("golden.light.factors.hemisphere_rows.HemisphereRows.rows", fails)
        assert run("formfactors", *SCENE, "-o", "F.npz", "--resume").exit_code == 0
    assert (folder / "F.npz").read_bytes() == (folder / "whole.npz").read_bytes()
    assert [path.name for path in sorted(folder.iterdir())] == ["F.npz", "whole.npz"]


def test_facets_that_overlap_are_an_error_if_strict(folder):
    # The first facet is cut into several patches.
    (folder / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 0 0\nv 7 0 0\nv 6 1 0\nv 7 2 0\nv 5 2 0\n"
                                  "f 5 6 7 8 9\nf 1 2 3 4\nf 1 2 3 4\n")
    given = "formfactors", "a.obj", "--facets", "--error", "0.1", "-o", "F.npz"
    loose = run(*given)
    assert loose.exit_code == 0, loose.stderr
    assert loose.stderr.startswith("warning: a: patches 1 and 2 overlap in one plane")
    (folder / "F.npz").unlink()
    assert run(*given, "--strict").exit_code == 2
    assert not (folder / "F.npz").exists()


@pytest.mark.parametrize("given", [(), ("--rays", "256x64", "--samples", "4")])
def test_a_facet_of_any_shape_is_one_row(folder, given):
    """Opposed L shapes at distance 1: squares of side 2 without a quarter.

    A quarter sees as much of the whole square as any other one, so A F of the L shapes is half of that of the squares
    and that of two quarters.
    """
    shape = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    (folder / "a.obj").write_text("".join(f"v {x} {y} {z}\n" for z in (0, 1) for x, y in shape)
                                  + "g low\nf 1 2 3 4 5 6\nf 12 11 10 9 8 7\n")
    found = run("formfactors", "a.obj", "--facets", "-o", "F.npz", *given)
    assert found.exit_code == 0, found.stderr
    factors = ViewFactors.open(folder / "F.npz")
    expected = (2 * c_11(2, 2) + c_11(1, 1)) / 3
    np.testing.assert_allclose(factors.F.toarray(), [[0, expected], [expected, 0]], atol=1e-2 if given else 1e-9)
    np.testing.assert_allclose(factors.area, 3)
    assert (factors.patch.tolist(), factors.normal[:, 2].tolist()) == ([0, 1], [1, -1])
    assert "F.npz: 2 patches, 2 entries" in found.stdout


def test_small_factors_are_left_out_and_rows_close(folder):
    """Furnace: each of 24 squares sees 20 others, and some of those by less than 0.03; surfaces lose nothing."""
    given = "formfactors", "furnace:2", "--error", "0.1"
    whole = json.loads(run(*given, "-o", "F.npz", "--json").stdout)
    text = run(*given, "-o", "F.npz", "--by-surface", "s.csv").stdout
    assert text.endswith("\ns.csv: 1 surface, as surfaces are named by materials, and there is one\n")
    cut = json.loads(run(*given, "-o", "cut.npz", "--drop-below", "0.03", "--by-surface", "s.npz", "--json").stdout)
    before, after, surfaces = (ViewFactors.open(folder / f"{name}.npz") for name in ("F", "cut", "s"))
    small = (before.F.toarray() < 0.03) & (before.F.toarray() > 0)
    assert cut["entries"] == whole["entries"] - small.sum() + 24 > 24
    lost = (before.F.toarray() * small).sum(axis=1)
    np.testing.assert_allclose(after.F.diagonal(), lost)
    assert cut["largest_dropped"] == pytest.approx(lost.max())
    assert (after.closure, after.reciprocity) == (pytest.approx(0, abs=1e-12), pytest.approx(0, abs=1e-12))
    np.testing.assert_allclose(surfaces.F.toarray(), 1)


def test_parts_of_a_facet_that_a_limit_cuts_stay_rows(folder):
    (folder / "a.obj").write_text("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 1 0\nv 0 2 0\nf 1 2 3 4 5\n")
    assert run("formfactors", "a.obj", "--facets", "-o", "F.npz", "--max-area", "0.5").exit_code == 0
    factors = ViewFactors.open(folder / "F.npz")
    assert factors.area.max() <= 0.5
    assert factors.area.sum() == pytest.approx(3)


def test_samples_alone_choose_hemispheres(folder):
    """As `--rays` does; the adaptive factors have errors."""
    reports = [json.loads(run("formfactors", "furnace:1", *given, "-o", "F.npz", "--json").stdout)
               for given in ((), ("--samples", "2"), ("--rays", "64x16"))]
    assert [report["error"] is None for report in reports] == [False, True, True]


class Recorded:
    """Remembers the options of all that a command makes."""

    def __init__(self):
        self.given = {}

    def of(self, name, made=None):
        """A function that remembers its options."""
        def make(*arguments, **options):
            self.given[name] = options | dict(enumerate(arguments))
            return made
        return make


@pytest.mark.parametrize(("words", "expected"), [
    (("--error", "0.002", "--sky-error", "0.003", "--sky-patches", "tregenza", "--seed", "7"),
     {"adaptive": {"error": 0.002, "sky_error": 0.003, "sky_patches": "tregenza", "seed": 7}}),
    (("--rays", "32x8", "--samples", "3", "--project"),
     {"plain": {"rays": (32, 8), "samples": 3, "projected": True, "block_rows": 64}}),
    (("--samples", "2"), {"plain": {"rays": (256, 64), "samples": 2, "projected": False}}),
    (("--time-limit", "5", "--error", "0.004"), {"within": {0: 5.0, "error": 0.004, "method": "grid"}}),
    (("--jobs", "3"), {"caster": {"jobs": 3, "cell": 0.3}}),
    (("--resume",), {"store": {"method": "grid", "resume": True}}),
    (("--receivers", "p.txt", "r.csv", "--error", "0.005", "--seed", "3"),
     {"task": {"receivers": (Path("p.txt"), Path("r.csv"))}, "receive": {0: 1, "error": 0.005, "seed": 3}}),
    (("--period", "30,20"), {"task": {"period": (30, 20)}}),
    (("--drop-below", "0.003"), {"task": {"drop_below": 0.003}}),
    (("--by-surface", "s.csv"), {"task": {"surfaces": Path("s.csv")}}),
    (("--sky-patches", "reinhart", "--zenith", "0,1,0"), {"task": {"zenith": (0, 1, 0), "has_sky_patches": True}}),
    (("--facets", "--unit", "cm", "--max-edge", "0.5", "--max-area", "0.25"),
     {"task": {"facets": True, "unit": "cm", "max_edge": 0.5, "max_area": 0.25, "zenith": None,
               "has_sky_patches": False}})])
def test_every_option_reaches_the_work(words, expected, monkeypatch, tmp_path):
    seen = Recorded()
    task = SimpleNamespace(scene=range(2), run=seen.of("run", ({}, "")), run_within=seen.of("within", ({}, "")),
                           rows=seen.of("adaptive"), store=seen.of("store"), receive=seen.of("receive", ({}, "")))
    for place, name, made in (
            ("radiosity.tasks.view_factors.ViewFactorTask", "task", task),
            ("golden.engine.cast.methods.frustum_caster", "caster", 1),
            ("golden.light.factors.hemisphere_rows.HemisphereRows", "plain", None),
            ("radiosity.cli.golden.formfactors.worker_pool", "pool", nullcontext())):
        monkeypatch.setattr(place, seen.of(name, made))
    result = run("formfactors", "furnace:1", "-o", tmp_path / "a.npz", "--method", "grid", "--cell", "0.3", *words)
    assert result.exit_code == 0, result.stderr
    if "within" in expected:
        seen.given["within"][1](0.01)
        expected = expected | {"adaptive": {"error": 0.01, "seed": 0}}
    for name, options in (expected | {"caster": {1: "grid", "cell": 0.3}, "pool": {"cell": 0.3}}).items():
        assert {key: seen.given[name][key] for key in options} == options


def test_one_line_says_that_grid_casts_where_embree_is_missing(folder, monkeypatch):
    """Without the wheel the factors are those of grid; a method that is named needs no line."""
    monkeypatch.setattr(shared_caster, "has_embree", lambda: False)
    fallen, named = (run("formfactors", *SCENE, *method, "-o", name)
                     for method, name in (((), "F.npz"), (("--method", "grid"), "G.npz")))
    assert fallen.exit_code == named.exit_code == 0, fallen.stderr
    assert sum("installs Embree" in line for line in fallen.stderr.splitlines()) == 1
    assert "installs Embree" not in named.stderr
    ours, theirs = (ViewFactors.open(folder / name) for name in ("F.npz", "G.npz"))
    np.testing.assert_array_equal(ours.F.toarray(), theirs.F.toarray())


def test_rays_cast_again_are_counted_and_sums_stay_exact(tmp_path):
    """Without the option 20 patches cast 32 x 16 rays each."""
    path = tmp_path / "F.npz"
    found = report("formfactors", "cornell", "-o", path, "--method", "shelling", "--rays", "32x16", "--least-rays", 16)
    assert found["rays"] > 20 * 512
    with np.load(path) as factors:
        assert factors["weight_bits"] == 32 + 7
        assert factors["row_sums"].max() == 1 << 39
