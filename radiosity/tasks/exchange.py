"""Net radiative exchange of a scene, from files to a file."""

import csv
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.output import check_inputs_stay, check_named_once, check_outputs, whole_file
from golden.base.plural import counted
from golden.light.factors.exchange import PatchError, net_exchange, script_f
from golden.light.factors.view_factors import ViewFactors
from golden.scene.file_text import number as number_of

__all__ = ["exchange"]

_VALUES = ("temperature", "emissivity", "flux")
_COLUMNS = ("patch", "surface", "area", "temperature", "emissivity", "radiosity", "irradiance", "flux")


def exchange(source: Path, table: Path, output: Path, *, sky_temperature: float,
             script: Path | None) -> tuple[dict, str]:
    """Compute the net exchange of all patches and write it; the report as values and as text.

    Parameters
    ----------
    source
        View factors, see `golden.light.factors.view_factors.ViewFactors.open`.
    table
        A .csv with the columns surface (or patch, from 0), temperature, emissivity and flux, one row for each.
    output
        A .csv with one row for each patch.
    sky_temperature
        See `net_exchange`.
    script
        A .csv for script-F between surfaces, or None.

    Raises
    ------
    InputError
        A file cannot be read or written, or its values cannot be used.
    """
    check_outputs(output, script, suffixes=(".csv",))
    check_named_once(output, script)
    check_inputs_stay(source, table, outputs=(output, script))
    factors = ViewFactors.open(source)
    given, source_of = _read_table(table, factors)
    try:
        found = net_exchange(factors, sky_temperature=sky_temperature, **given)
    except PatchError as error:
        raise InputError(f"{table}: {source_of[error.patch]}: {error.fault}") from error
    names, group = np.unique(factors.surface, return_inverse=True)
    shares = script_f(factors, emissivity=given["emissivity"], group=group) if script else None
    columns = {"patch": np.arange(len(factors)), "surface": factors.surface, "area": factors.area,
               "emissivity": given["emissivity"], **vars(found)}
    rows = zip(*(columns[name].tolist() for name in _COLUMNS), strict=True)
    _write(output, [_COLUMNS, *rows])
    if script:
        _write(script, [("surface", *names.tolist()),
                        *((name, *row) for name, row in zip(names.tolist(), shares.tolist(), strict=True))])
    area, heat = (np.bincount(group, values) for values in (factors.area, factors.area * found.flux))
    surfaces = [{"surface": name, "area": size, "heat": loss} for name, size, loss in
                zip(names.tolist(), area.tolist(), heat.tolist(), strict=True)]
    report = {"output": output, "patches": len(factors), "surfaces": surfaces, "heat_to_sky": heat.sum()}
    outside = f"sky of {sky_temperature:g} K"
    width = max(map(len, [*names.tolist(), outside]))
    lines = [f"{output}: {counted(len(factors), 'patch')}", f"{'surface':{width}} {'area, m2':>12} {'net heat, W':>14}",
             *(f"{row['surface']:{width}} {row['area']:12.6g} {row['heat']:14.6g}" for row in surfaces),
             f"{outside:{width}} {'':12} {heat.sum():14.6g}"]
    return report, "\n".join(lines)


def _read_table(path: Path, factors: ViewFactors) -> tuple[dict, list[str]]:
    """Temperature, emissivity and flux of each patch; and line and name of the row that gives them."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            header = [name.strip() for name in reader.fieldnames or []]
            reader.fieldnames = header
            rows = [(reader.line_num, row) for row in reader]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from error
    key = "patch" if "patch" in header else "surface"
    missing = [name for name in (key, "temperature", "emissivity") if name not in header]
    unknown = [name for name in header if name not in ("patch", "surface", *_VALUES)]
    if missing or unknown or len(set(header)) < len(header):
        raise InputError(f"{path}: Header must name surface or patch, temperature, emissivity and perhaps flux, "
                         f"each once, not {', '.join(header) or 'nothing'}")
    names = [str(number) for number in range(len(factors))] if key == "patch" else [
        name.strip() for name in factors.surface.tolist()]
    known, values, source = set(names), {}, {}
    for number, row in rows:
        if None in row:
            raise InputError(f"{path}: line {number}: it has more values than the header has names")
        name = (row[key] or "").strip()
        if name not in known:
            raise InputError(f"{path}: line {number}: there is no {key} {name!r}")
        if name in values:
            raise InputError(f"{path}: line {number}: {key} {name!r} has a row already")
        if not (row["emissivity"] or "").strip():
            raise InputError(f"{path}: line {number}: {key} {name!r} has no emissivity")
        values[name] = [_number(path, number, one, row.get(one)) for one in _VALUES]
        source[name] = f"line {number}: {key} {name!r}"
    absent = sorted(known - values.keys())
    if absent:
        raise InputError(f"{path}: there is no row for {key} {absent[0]!r}"
                         f"{f' and {len(absent) - 1} more' if len(absent) > 1 else ''}")
    return (dict(zip(_VALUES, np.array([values[name] for name in names]).T, strict=True)),
            [source[name] for name in names])


def _number(path, line, name, word):
    """The value of a cell, NaN of an empty one."""
    try:
        return number_of(word.strip()) if word and word.strip() else np.nan
    except ValueError:
        raise InputError(f"{path}: line {line}: {name.capitalize()} must be a number, not {word!r}") from None


def _write(path, rows):
    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
