import csv

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.io import netcdf_file

from golden.base.errors import InputError
from golden.light.factors import netcdf_file as netcdf
from golden.light.factors.files import (
    check_view_factors_output,
    write_by_surface,
    write_view_factors,
)
from golden.light.factors.view_factors import ViewFactors
from tb.golden.light.factors.samples import sparse_sides, three_sides
from tb.lib.schedules import SETTINGS


def same(one, other):
    if sparse.issparse(one):
        return one.shape == other.shape and all(
            same(getattr(one, part), getattr(other, part)) for part in ("data", "indices", "indptr"))
    return np.array_equal(one, other)


@pytest.mark.parametrize("suffix", [".npz", ".nc"])
@pytest.mark.parametrize("changed", [
    {}, {"error": None, "unprojected": None, "unprojected_sky": None, "sky_error": None, "sky_patches": None,
         "sky_patches_error": None},
    {"sky_patches_error": None}, dict.fromkeys(("sky_patches", "sky_patches_error"), sparse.csr_array((3, 4)))],
                         ids=["all", "plain", "without errors of the sky", "dark"])
def test_what_is_written_is_read(tmp_path, suffix, changed):
    path, factors = tmp_path / f"F{suffix}", three_sides(**changed)
    write_view_factors(factors, path)
    read = ViewFactors.open(path)
    rays = {"row_sums", "weight_bits"} if suffix == ".nc" else set()
    for name in vars(factors).keys() - rays:
        assert same(getattr(factors, name), getattr(read, name)), name


@settings(SETTINGS, max_examples=40)
@given(factors=sparse_sides(), suffix=st.sampled_from((".npz", ".nc")))
def test_empty_rows_are_read_as_they_are(tmp_path_factory, factors, suffix):
    path = tmp_path_factory.getbasetemp() / f"F{suffix}"
    write_view_factors(factors, path)
    read = ViewFactors.open(path)
    for name in vars(factors).keys() - {"row_sums", "weight_bits"}:
        # A netCDF file without entries stores one of 0.
        one, other = (value.toarray() if sparse.issparse(value) else value for value in (
            getattr(factors, name), getattr(read, name)))
        assert same(one, other), name


def test_scipy_loads_the_matrix(tmp_path):
    write_view_factors(three_sides(), tmp_path / "F.npz")
    loaded = sparse.load_npz(tmp_path / "F.npz")
    assert isinstance(loaded, sparse.csr_array)
    assert same(loaded, three_sides().F)


def test_variables_of_netcdf_have_units_and_names(tmp_path):
    write_view_factors(three_sides(), tmp_path / "F.nc")
    with netcdf_file(tmp_path / "F.nc", mmap=False) as file:
        assert file.Conventions == b"CF-1.11"
        assert file.variables["area"].units == b"m2"
        entries = zip(*(file.variables[name][:].tolist() for name in ("from_patch", "to_patch", "view_factor")),
                      strict=True)
        assert (0, 1, 0.3) in entries
        np.testing.assert_array_equal(file.variables["row_sum"][:], [[0.75, 1], [1, 1], [1, 1]])
        assert all(variable.long_name for variable in file.variables.values())


def test_a_matrix_too_long_for_a_variable_continues_in_more(tmp_path, monkeypatch):
    assert netcdf._MOST_ENTRIES * np.dtype(float).itemsize <= np.iinfo(np.int32).max
    monkeypatch.setattr(netcdf, "_MOST_ENTRIES", 4)
    factors = three_sides()
    assert factors.F.nnz == 6
    write_view_factors(factors, tmp_path / "F.nc")
    with netcdf_file(tmp_path / "F.nc", mmap=False) as file:
        assert {name: file.dimensions[name] for name in ("entry", "entry_2")} == {"entry": 4, "entry_2": 2}
        assert file.variables["view_factor_error_2"].dimensions == ("entry_2",)
    read = ViewFactors.open(tmp_path / "F.nc")
    for name in vars(factors).keys() - {"row_sums", "weight_bits"}:
        assert same(getattr(factors, name), getattr(read, name)), name


def test_files_of_urban_models_count_from_one(tmp_path):
    write_view_factors(three_sides(), tmp_path / "vfsparse.inp.065")
    lines = (tmp_path / "vfsparse.inp.065").read_text().splitlines()
    assert lines == ["1 2 0.3", "1 3 0.6", "2 1 0.25", "2 3 0.75", "3 1 0.4", "3 2 0.6"]
    assert (tmp_path / "svf.inp.065").read_text() == "# sky view factors\n0.06\n0\n0\n"
    assert (tmp_path / "facetarea.inp.065").read_text() == "# area of facets\n3\n4\n5\n"


def test_a_table_of_surfaces_has_all_that_leaves_each(tmp_path):
    """Of a triangular duct: the shares of each surface add up to 1, and a line without an error is empty there."""
    write_by_surface(three_sides(), tmp_path / "s.csv")
    with (tmp_path / "s.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [tuple(row.values()) for row in rows] == [
        (" (back)", "5.0", "Wand süd", "0.6", "0.006"), (" (back)", "5.0", "sun", "0.4", "0.004"),
        ("Wand süd", "4.0", " (back)", "0.75", "0.0075"), ("Wand süd", "4.0", "sun", "0.25", "0.0025"),
        ("sun", "3.0", " (back)", "0.6", "0.006"), ("sun", "3.0", "Wand süd", "0.3", "0.003"),
        ("sun", "3.0", "(sky)", "0.06", "0.01"), ("sun", "3.0", "(backs)", "0.04", "")]
    write_by_surface(three_sides(error=None, sky_error=None), tmp_path / "s.csv")
    with (tmp_path / "s.csv").open(encoding="utf-8", newline="") as file:
        assert {row["standard_error"] for row in csv.DictReader(file)} == {""}


def test_a_table_with_patches_of_the_sky_has_the_ground_apart(tmp_path):
    """Patch 0 is below the horizon, with 0.02 of the 0.06 that leave the side."""
    patches = sparse.csr_array([(0.02, 0.03, 0, 0.01), (0,) * 4, (0,) * 4])
    errors = sparse.csr_array([(0.003, 0.002, 0, 0.001), (0,) * 4, (0,) * 4])
    write_by_surface(three_sides(sky_patches=patches, sky_patches_error=errors), tmp_path / "s.csv")
    with (tmp_path / "s.csv").open(encoding="utf-8", newline="") as file:
        rows = {row["to"]: (float(row["view_factor"]), row["standard_error"]) for row in csv.DictReader(file)
                if row["from"] == "sun"}
    assert rows["(sky)"] == (pytest.approx(0.04), "0.01")
    assert rows["(ground)"] == (pytest.approx(0.02), "0.003")
    assert sum(value for value, _ in rows.values()) == pytest.approx(1)


@pytest.mark.parametrize("name", ["F.csv", "F", "vf.inp", "vfsparse.input"])
def test_other_names_are_refused(tmp_path, name):
    with pytest.raises(InputError, match=r"Name must end in \.npz or \.nc or be vfsparse\.inp or vfsparse\.inp\.CASE"):
        check_view_factors_output(tmp_path / name)


@pytest.mark.parametrize("name", ["F.npz", "F.nc", "F.NPZ", "vfsparse.inp"])
def test_a_path_that_cannot_be_written_is_refused_before_the_work(tmp_path, name):
    check_view_factors_output(tmp_path / name)
    with pytest.raises(InputError, match="none"):
        check_view_factors_output(tmp_path / "none" / name)


def test_each_file_of_an_urban_model_is_checked(tmp_path):
    (tmp_path / "svf.inp").mkdir()
    with pytest.raises(InputError, match=r"svf\.inp.*directory"):
        check_view_factors_output(tmp_path / "vfsparse.inp")


@pytest.mark.parametrize(("name", "content", "message"), [
    ("F.txt", b"", "Name must end in"), ("F.npz", None, "no such file"), ("F.npz", b"no zip", "no view factors"),
    ("F.nc", b"CDF\x02", "no view factors"), ("F.nc", b"", "no view factors")])
def test_files_without_view_factors_are_refused_with_their_name(tmp_path, name, content, message):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        ViewFactors.open(path)
    assert str(caught.value).startswith(str(path))


def test_archives_of_other_arrays_are_refused(tmp_path):
    np.savez(tmp_path / "F.npz", F=np.eye(3))
    with pytest.raises(InputError, match="no view factors"):
        ViewFactors.open(tmp_path / "F.npz")
    sparse.save_npz(tmp_path / "G.npz", sparse.csr_array(np.eye(3)))
    with pytest.raises(InputError, match="no view factors"):
        ViewFactors.open(tmp_path / "G.npz")


def test_entries_of_urban_models_have_ten_digits(tmp_path):
    write_view_factors(three_sides(F=sparse.csr_array(np.eye(3) / 3), error=None, unprojected=None),
                       tmp_path / "vfsparse.inp")
    assert (tmp_path / "vfsparse.inp").read_text().splitlines()[0] == "1 1 0.3333333333"
