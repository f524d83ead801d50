"""Files of view factors by their names."""

from pathlib import Path

from golden.base.errors import InputError
from golden.base.output import check_outputs, whole_file
from golden.light.factors.csv_file import write_csv
from golden.light.factors.factor_matrix import FactorMatrix
from golden.light.factors.groups import by_surface
from golden.light.factors.netcdf_file import write_netcdf
from golden.light.factors.npz_file import write_npz
from golden.light.factors.urban_files import URBAN, urban_paths, write_urban

__all__ = ["SURFACE_SUFFIXES", "check_view_factors_output", "write_by_surface", "write_view_factors"]

_WRITERS = {".npz": write_npz, ".nc": write_netcdf}
_SURFACE_WRITERS = {".csv": write_csv, **_WRITERS}
SURFACE_SUFFIXES = tuple(_SURFACE_WRITERS)
"""Endings of files of view factors between surfaces."""


def check_view_factors_output(path: Path) -> None:
    """`write_view_factors` can write to a path; to be checked before the work starts.

    Raises
    ------
    InputError
        Its name has no known ending, or no file can be made there.
    """
    if _is_urban(path):
        for one in urban_paths(path):
            check_outputs(one, suffixes=(one.suffix.lower(),))
    elif path.suffix.lower() in _WRITERS:
        check_outputs(path, suffixes=tuple(_WRITERS))
    else:
        raise InputError(f"output {str(path)!r}: Name must end in {' or '.join(_WRITERS)} or be {URBAN} or "
                         f"{URBAN}.CASE, not {path.name!r}")


def write_view_factors(factors: FactorMatrix, path: Path) -> None:
    """Write to the file, or files, whose format the name selects: .npz, .nc, or vfsparse.inp; each atomically."""
    if _is_urban(path):
        write_urban(factors, path)
        return
    with whole_file(path) as part:
        _WRITERS[path.suffix.lower()](factors, part)


def write_by_surface(factors: FactorMatrix, path: Path) -> int:
    """Write the factors between surfaces (`by_surface`) to a .csv, .nc or .npz, atomically; the number of surfaces."""
    surfaces = by_surface(factors)
    with whole_file(path) as part:
        _SURFACE_WRITERS[path.suffix.lower()](surfaces, part)
    return len(surfaces)


def _is_urban(path):
    return path.name == URBAN or (path.name.startswith(f"{URBAN}.") and not path.name.endswith("."))
