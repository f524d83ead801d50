"""View factors as NPZ: `scipy.sparse.load_npz` reads the matrix, `numpy.load` everything."""

import json
import zipfile
from pathlib import Path

import numpy as np
from scipy import sparse

from golden.light.factors.factor_matrix import FactorMatrix

__all__ = ["read_npz", "write_npz"]

_ARRAYS = ("sky", "back", "area", "normal", "surface", "patch", "front", "unprojected_sky", "sky_error", "row_sums",
           "weight_bits", "hidden_error")
_MATRICES = ("error", "unprojected")
_CSR = ("data", "indices", "indptr", "shape")


def write_npz(factors: FactorMatrix, path: Path) -> None:
    """Write an archive with the arrays of SciPy's CSR format and those of `FactorMatrix`.

    ``error`` and ``unprojected`` hold one number for each entry of ``data``; ``sky_patches_data``, ``_indices``,
    ``_indptr`` and ``_shape`` are a matrix of their own, of which ``sky_patches_error`` holds one for each entry.
    """
    matrix = factors.F
    arrays = {"format": np.array(b"csr"), "_is_array": np.array(True), "shape": np.array(matrix.shape),
              "data": matrix.data, "indices": matrix.indices, "indptr": matrix.indptr,
              "settings": np.array(json.dumps(factors.settings, sort_keys=True))}
    arrays |= {name: getattr(factors, name) for name in _ARRAYS}
    arrays |= {name: None if getattr(factors, name) is None else getattr(factors, name).data for name in _MATRICES}
    if factors.sky_patches is not None:
        arrays |= {f"sky_patches_{name}": np.asarray(getattr(factors.sky_patches, name)) for name in _CSR}
        arrays["sky_patches_error"] = None if factors.sky_patches_error is None else factors.sky_patches_error.data
    with path.open("wb") as file:  # to a path that does not end in .npz savez would add this
        np.savez(file, **{name: value for name, value in arrays.items() if value is not None})


def read_npz(path: Path) -> dict:
    """The fields of the `FactorMatrix` of an archive that `write_npz` wrote.

    Raises
    ------
    OSError, ValueError, KeyError
        It is no such archive.
    """
    if not zipfile.is_zipfile(path):
        raise ValueError("it is no .npz archive")
    with np.load(path) as stored:
        arrays = dict(stored)
    pattern = arrays["indices"], arrays["indptr"]
    shape = arrays["shape"]
    given = {name: arrays[name] for name in _ARRAYS if name in arrays}
    given |= {name: _matrix(arrays[name], *pattern, shape) for name in _MATRICES if name in arrays}
    if "weight_bits" in given:
        given["weight_bits"] = int(given["weight_bits"])
    if "hidden_error" in given:
        given["hidden_error"] = float(given["hidden_error"])
    if "sky_patches_data" in arrays:
        sky = [arrays[f"sky_patches_{name}"] for name in _CSR]
        given["sky_patches"] = _matrix(*sky)
        if "sky_patches_error" in arrays:
            given["sky_patches_error"] = _matrix(arrays["sky_patches_error"], *sky[1:])
    return {"F": _matrix(arrays["data"], *pattern, shape), "settings": json.loads(str(arrays["settings"])), **given}


def _matrix(data, indices, indptr, shape):
    matrix = sparse.csr_array((data, indices, indptr), shape=tuple(shape.tolist()))
    # SciPy's products do not check indices and would read beyond an array.
    matrix.check_format(full_check=True)
    return matrix
