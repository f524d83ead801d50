"""View factors as netCDF, named after the CF conventions."""

import json
from itertools import count as numbers
from pathlib import Path

import numpy as np
from scipy import sparse
from scipy.io import netcdf_file

from golden.light.factors.factor_matrix import FactorMatrix

__all__ = ["read_netcdf", "variables", "write_netcdf"]

# Variable: its dimensions, units and long name. The matrix is a list of entries; a standard name exists for none.
_VARIABLES = {
    "view_factor": (("entry",), "1", "share of the radiation leaving patch from_patch that arrives at to_patch"),
    "view_factor_error": (("entry",), "1", "standard error of view_factor; 0 where it is exact"),
    "view_factor_unprojected": (("entry",), "1", "view_factor before closure and reciprocity were enforced"),
    "sky_view_factor": (("patch",), "1", "share of the radiation leaving a patch that leaves the scene"),
    "sky_view_factor_error": (("patch",), "1", "standard error of sky_view_factor"),
    "back_view_factor": (("patch",), "1", "share of the radiation leaving a patch that meets black backs"),
    "sky_view_factor_unprojected": (("patch",), "1", "sky_view_factor before closure was enforced"),
    "area": (("patch",), "m2", "area of a patch"),
    "normal": (("patch", "axis"), "1", "unit normal out of the radiating side of a patch"),
    "scene_patch": (("patch",), None, "number of the patch in the scene, from 0"),
    "front": (("patch",), None, "1 for the front of that patch, 0 for its back"),
    "from_patch": (("entry",), None, "number of the patch that radiates, from 0"),
    "to_patch": (("entry",), None, "number of the patch that receives, from 0"),
    "sky_patch_view_factor": (("sky_entry",), "1", "share of the radiation leaving sky_from_patch for to_sky_patch"),
    "sky_patch_view_factor_error": (("sky_entry",), "1", "standard error of sky_patch_view_factor"),
    "sky_from_patch": (("sky_entry",), None, "number of the patch that radiates, from 0"),
    "to_sky_patch": (("sky_entry",), None, "number of the patch of the sky: 0 is below the horizon"),
    "row_sum": (("patch", "sample"), "1", "share of each hemisphere of rays that met a patch"),
}

_SKY_PATCHES = "sky_patch_view_factor", "sky_patch_view_factor_error"

# Entries of a variable: its bytes must fit in a signed word of 32 bits. More entries continue in further variables.
_MOST_ENTRIES = (1 << 28) - 1


def variables(factors: FactorMatrix) -> dict[str, tuple]:
    """By name the dimensions, the unit or None, the long name and the values of the variables that factors have."""
    matrix = factors.F.tocoo()
    values = {"from_patch": matrix.row.astype(np.int32), "to_patch": matrix.col.astype(np.int32),
              "view_factor": matrix.data, "area": factors.area, "normal": factors.normal,
              "sky_view_factor": factors.sky, "back_view_factor": factors.back,
              "scene_patch": factors.patch.astype(np.int32), "front": factors.front.astype(np.int8),
              "sky_view_factor_unprojected": factors.unprojected_sky, "sky_view_factor_error": factors.sky_error}
    values |= {f"view_factor_{suffix}": value.data for suffix, value in
               (("error", factors.error), ("unprojected", factors.unprojected)) if value is not None}
    if factors.row_sums is not None:
        values["row_sum"] = factors.row_sums / 2.0**factors.weight_bits
    sky = None if factors.sky_patches is None else factors.sky_patches.tocoo()
    if sky is not None and sky.nnz:
        values |= {"sky_patch_view_factor": sky.data, "sky_from_patch": sky.row.astype(np.int32),
                   "to_sky_patch": sky.col.astype(np.int32),
                   "sky_patch_view_factor_error":
                   None if factors.sky_patches_error is None else factors.sky_patches_error.data}
    return {name: (*_VARIABLES[name], value) for name, value in values.items() if value is not None}


def write_netcdf(factors: FactorMatrix, path: Path) -> None:
    """Write a netCDF file of version 3 (64-bit offsets), which xarray and all netCDF libraries read.

    The matrix is a list: ``view_factor(entry)`` with ``from_patch(entry)`` and ``to_patch(entry)``, which count from 0.
    After 2^28 - 1 entries, as many as a variable holds, the list continues in ``view_factor_2(entry_2)`` and so on.
    """
    values = {name: part for name, (_, _, _, part) in variables(factors).items()}
    if not factors.F.nnz:  # a dimension of length 0 is the unlimited one in this format
        values = {name: np.zeros(1, dtype=value.dtype) if _VARIABLES[name][0] == ("entry",) else value
                  for name, value in values.items()}
    sky = factors.sky_patches
    names = np.array([name.encode() for name in factors.surface.tolist()])
    with netcdf_file(path, "w", version=2) as file:
        if sky is not None:
            file.sky_patches = np.int32(sky.shape[1])
            file.sky_patches_have_errors = np.int8(factors.sky_patches_error is not None)
        file.Conventions, file.title = "CF-1.11", "View factors between patches, with occlusion"
        file.source, file.settings = "radiosity-engine", json.dumps(factors.settings, sort_keys=True)
        file.hidden_error = np.float64(factors.hidden_error)
        lengths = {"patch": len(factors), "axis": 3, "name_length": names.itemsize or 1}
        if factors.row_sums is not None:
            lengths["sample"] = factors.row_sums.shape[1]
        for name, length in lengths.items():
            file.createDimension(name, length)
        for name, (dimensions, units, about) in _VARIABLES.items():
            if name not in values:
                continue
            for suffix, part in _parts(values[name], dimensions[0]):
                if dimensions[0] + suffix not in file.dimensions:
                    file.createDimension(dimensions[0] + suffix, len(part))
                variable = file.createVariable(name + suffix, part.dtype.str[1:],
                                               (dimensions[0] + suffix, *dimensions[1:]))
                variable.long_name = about
                if units:
                    variable.units = units
                if dimensions == ("patch",):
                    variable.coordinates = "surface_name"
                variable[:] = part
        variable = file.createVariable("surface_name", "S1", ("patch", "name_length"))
        variable.long_name, variable._Encoding = "name of the surface that a patch belongs to", "utf-8"
        variable[:] = np.frombuffer(names.astype(f"S{lengths['name_length']}").tobytes(), "S1").reshape(len(names), -1)


def read_netcdf(path: Path) -> dict:
    """The fields of the `FactorMatrix` of a file that `write_netcdf` wrote, without row sums of rays.

    Raises
    ------
    OSError, ValueError, KeyError, TypeError
        It is no such file.
    """
    with netcdf_file(path, "r", mmap=False) as file:
        values = {name: np.array(variable[:]) for name, variable in file.variables.items()}
        settings, hidden_error = json.loads(file.settings), float(file.hidden_error)
        sky_patches = getattr(file, "sky_patches", None)
        have_errors = int(getattr(file, "sky_patches_have_errors", 0))
    values = {name: value.astype(value.dtype.newbyteorder("=")) for name, value in values.items()}
    for name in values.keys() & _VARIABLES.keys():
        if f"{name}_2" in values:
            values[name] = np.concatenate(list(_read_parts(values, name)))
    count = len(values["area"])
    names = values["surface_name"]
    pattern = values["from_patch"], values["to_patch"]

    def matrix(name):
        return sparse.coo_array((values[name], pattern), shape=(count, count)).tocsr() if name in values else None

    sky, sky_error = None, []
    if sky_patches is not None:
        place = [values.get(name, []) for name in ("sky_from_patch", "to_sky_patch")]
        sky, *sky_error = (sparse.csr_array((values.get(name, []), place), shape=(count, int(sky_patches)),
                                           dtype=np.float64) for name in _SKY_PATCHES[:1 + have_errors])
    return {"F": matrix("view_factor"), "error": matrix("view_factor_error"),
            "unprojected": matrix("view_factor_unprojected"), "sky": values["sky_view_factor"],
            "unprojected_sky": values.get("sky_view_factor_unprojected"),
            "sky_error": values.get("sky_view_factor_error"), "sky_patches": sky,
            "sky_patches_error": sky_error[0] if sky_error else None, "area": values["area"],
            "normal": values["normal"], "settings": settings, "hidden_error": hidden_error,
            "back": values["back_view_factor"], "patch": values["scene_patch"].astype(np.int64),
            "front": values["front"].astype(bool),
            "surface": np.array([b"".join(name).rstrip(b"\0").decode() for name in names])}


def _parts(value, dimension):
    """Suffixes of names and slices of a variable that may be too long for one."""
    if dimension not in ("entry", "sky_entry"):
        yield "", value
        return
    for start in range(0, len(value), _MOST_ENTRIES):
        yield f"_{start // _MOST_ENTRIES + 1}" if start else "", value[start:start + _MOST_ENTRIES]


def _read_parts(values, name):
    """The slices of a variable, in their order."""
    yield values[name]
    for number in numbers(2):
        if f"{name}_{number}" not in values:
            return
        yield values[f"{name}_{number}"]
