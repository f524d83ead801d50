"""Files of view factors by their names."""

from pathlib import Path

from golden.base.errors import InputError
from golden.base.output import check_outputs, whole_file
from golden.light.factors.csv_file import write_csv
from golden.light.factors.groups import by_surface
from golden.light.factors.netcdf_file import read_netcdf, write_netcdf
from golden.light.factors.npz_file import read_npz, write_npz
from golden.light.factors.urban_files import URBAN, urban_paths, write_urban
from golden.light.factors.view_factors import ViewFactors

__all__ = ["SURFACE_SUFFIXES", "check_view_factors_output", "read_view_factors", "write_by_surface",
           "write_view_factors"]

_WRITERS = {".npz": write_npz, ".nc": write_netcdf}
_READERS = {".npz": read_npz, ".nc": read_netcdf}
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


def write_view_factors(factors: ViewFactors, path: Path) -> None:
    """Write to the file, or files, whose format the name selects: .npz, .nc, or vfsparse.inp; each atomically."""
    if _is_urban(path):
        write_urban(factors, path)
        return
    with whole_file(path) as part:
        _WRITERS[path.suffix.lower()](factors, part)


def write_by_surface(factors: ViewFactors, path: Path) -> int:
    """Write the factors between surfaces (`by_surface`) to a .csv, .nc or .npz, atomically; the number of surfaces."""
    surfaces = by_surface(factors)
    with whole_file(path) as part:
        _SURFACE_WRITERS[path.suffix.lower()](surfaces, part)
    return len(surfaces)


def read_view_factors(path: Path) -> ViewFactors:
    """The view factors of a .npz or .nc file that `write_view_factors` wrote.

    Raises
    ------
    InputError
        One line with the path and the fault.
    """
    path = Path(path)
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path}: Name must end in {' or '.join(_READERS)}, not {path.suffix!r}")
    if not path.exists():
        raise InputError(f"{path}: no such file")
    try:
        return reader(path)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    except Exception as error:  # the libraries raise errors of any type for bad content
        raise InputError(f"{path}: it holds no view factors ({' '.join(str(error).split())})") from error


def _is_urban(path):
    return path.name == URBAN or (path.name.startswith(f"{URBAN}.") and not path.name.endswith("."))
