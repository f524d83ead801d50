import subprocess
import sys

import numpy as np
import pytest
import trimesh
from scipy import sparse

from benchmarks.closed_forms import c_11
from golden import view_factors
from golden.base.errors import InputError, InputWarning
from golden.light.factors import interface
from golden.light.factors.rows import FactorRows
from golden.light.factors.view_factors import ViewFactors
from golden.scene.builtin import builtin_scene

FAST = {"error": 0.05}
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
PLATES = [SQUARE, [(x, y, 1) for x, y, _ in reversed(SQUARE)]]


def test_two_plates():
    factors = view_factors(PLATES, names=["floor", "lid"])
    assert isinstance(factors.F, sparse.csr_array)
    assert factors.F[0, 1] == pytest.approx(c_11(1, 1), abs=1e-6)
    assert factors.sky[0] == pytest.approx(1 - c_11(1, 1), abs=1e-6)
    assert factors.surface.tolist() == ["floor", "lid"]
    np.testing.assert_array_equal(factors.normal, [(0, 0, 1), (0, 0, -1)])


@pytest.mark.parametrize("two_sided", [False, True])
def test_a_facet_that_rounding_has_bent_sees_the_sky_alone(two_sided):
    factors = view_factors([[(x, y, bend) for (x, y, _), bend in zip(SQUARE, (0, 1e-9, 0, 1e-9), strict=True)]],
                           two_sided=two_sided)
    assert factors.F.nnz == 0
    np.testing.assert_array_equal(factors.sky, 1)
    np.testing.assert_array_equal(factors.sky_error, 0)


def test_a_mesh_is_its_triangles():
    box = trimesh.creation.box()
    box.invert()
    from_mesh, from_corners = view_factors(box, **FAST), view_factors(box.triangles, **FAST)
    assert from_mesh.F.shape == (12, 12)
    assert (from_mesh.F != from_corners.F).nnz == 0
    np.testing.assert_allclose(from_mesh.F.sum(axis=1), 1)


def test_a_scene_stays_as_it_is():
    factors = view_factors(builtin_scene("furnace:1"), **FAST)
    assert len(factors) == 6
    assert set(factors.surface) == {"wall"}


def test_two_sided_facets_have_a_row_for_each_side():
    above = [(x, y, 2) for x, y, _ in PLATES[1]]
    factors = view_factors([*PLATES, above], names=["a", "b", "c"], two_sided=True, **FAST)
    assert len(factors) == 6
    assert factors.patch.tolist() == [0, 1, 2, 0, 1, 2]
    assert factors.front.tolist() == [True] * 3 + [False] * 3
    assert factors.surface.tolist() == ["a", "b", "c"] * 2
    # The middle one hides the others from each other, and its back sees the uppermost.
    assert factors.F[0, 1] == pytest.approx(0.2, abs=0.05)
    assert factors.F[4, 2] == pytest.approx(0.2, abs=0.05)
    assert factors.F[0, 2] == factors.F[2, 0] == 0
    np.testing.assert_array_equal(factors.normal[4], (0, 0, 1))


def test_black_backs_take_what_is_no_sky():
    factors = view_factors([PLATES[0], PLATES[1][::-1]], **FAST)
    assert factors.back[0] == pytest.approx(0.2, abs=0.05)
    assert factors.F.sum() == factors.back[1] == 0
    np.testing.assert_allclose(factors.sky + factors.back, 1)


def test_each_parameter_arrives_at_the_rows(monkeypatch):
    given = {"error": 0.06, "sky_error": 0.03, "sky_patches": "reinhart", "seed": 8}
    found = {}

    def rows(scene, caster, **named):
        found.update(named)
        return FactorRows(scene, caster, **named)

    monkeypatch.setattr(interface, "FactorRows", rows)
    view_factors(PLATES, **given)
    assert found == given


@pytest.mark.parametrize(("write", "suffix"), [("to_npz", ".npz"), ("to_netcdf", ".nc")])
def test_files_are_those_of_the_command(tmp_path, write, suffix):
    factors, path = view_factors(PLATES, **FAST), tmp_path / f"F{suffix}"
    getattr(factors, write)(path)
    assert (ViewFactors.open(path).F != factors.F).nnz == 0


def test_facets_that_overlap_are_named():
    with pytest.warns(InputWarning, match="facets: patches 0 and 1 overlap in one plane: each counts"):
        view_factors([SQUARE, *PLATES], error=0.1)


def test_areas_are_square_metres_whatever_the_unit():
    metres, inches = view_factors(PLATES, **FAST), view_factors(PLATES, unit="in", **FAST)
    np.testing.assert_allclose(inches.area, metres.area * 0.0254**2, rtol=1e-15)
    assert inches.settings["unit"] == "in"
    assert (inches.F != metres.F).nnz == 0


@pytest.mark.parametrize(("write", "name"), [("to_npz", "a"), ("to_npz", "a.nc"), ("to_netcdf", "a.npz")])
def test_files_with_another_ending_are_refused(tmp_path, write, name):
    with pytest.raises(InputError, match="Name must end in"):
        getattr(view_factors(PLATES, **FAST), write)(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_capitals_end_a_name_as_well(tmp_path):
    view_factors(PLATES, **FAST).to_npz(tmp_path / "F.NPZ")
    assert [path.name for path in tmp_path.iterdir()] == ["F.NPZ"]
    assert len(ViewFactors.open(tmp_path / "F.NPZ")) == 2


@pytest.mark.parametrize(("geometry", "given", "message"), [
    (np.zeros((2, 5, 3)), {}, "N x 3 x 3 or N x 4 x 3, not"), (np.zeros((0, 3, 3)), {}, "N x 3 x 3 or N x 4 x 3"),
    (np.full((1, 3, 3), np.nan), {}, "finite"), (np.zeros((1, 3, 3)), {}, "facet 1 has no area"),
    ([[(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]], {}, "facet 1 is not planar and strictly convex"),
    (PLATES, {"seed": -1}, "Seed must be"), (PLATES, {"jobs": 0}, "Jobs must be 1 to 256, not 0"),
    (PLATES, {"names": ["a"]}, "one for each of 2 facets, not 1"),
    (PLATES, {"error": "small"}, "Error must be 1e-6 to 0.1, not 'small'"), (PLATES, {"error": None}, "not None"),
    ("cornell", {}, "not str"), (trimesh.PointCloud([(0, 0, 0), (1, 0, 0)]), {}, "not PointCloud"),
    (PLATES, {"two_sided": "x"}, "True or False, not 'x'"), (PLATES, {"unit": "yard"}, "Unit must be m or mm"),
    (PLATES, {"method": "magic"}, "grid or naive or embree"),
    (builtin_scene("furnace:1"), {"two_sided": True}, "those of the scene")])
def test_what_cannot_be_used_is_refused(geometry, given, message):
    with pytest.raises(InputError, match=message):
        view_factors(geometry, **given)


def test_the_package_imports_nothing_until_it_is_used():
    code = "import sys, golden; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.split() == ["False"]
