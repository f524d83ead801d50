"""What docs/figures/ has recorded of the hardware."""

import csv
from collections.abc import Iterable
from typing import TypeVar, get_type_hints

from golden.base.errors import InputError
from radiosity.flow.synthesis.history import ROOT

__all__ = ["check_recorded", "read_rows"]

Row = TypeVar("Row")


def read_rows(name: str, kind: type[Row]) -> tuple[Row, ...]:
    """The rows of docs/figures/NAME.csv, as objects of a dataclass whose members are its columns."""
    types = get_type_hints(kind)
    with (ROOT / "docs" / "figures" / f"{name}.csv").open(newline="") as file:
        return tuple(kind(**{column: types[column](row[column]) for column in types}) for row in csv.DictReader(file))


def check_recorded(benchmark: str, scenes: Iterable[str], recorded: Iterable[str]) -> None:
    """The hardware's cycles are recorded of all ``scenes`` that are to be compared.

    Raises
    ------
    InputError
        They are not.
    """
    known = tuple(dict.fromkeys(recorded))
    for name in scenes:
        if name not in known:
            raise InputError(f"{benchmark}: Scenes must be of {', '.join(known)} with --calibrate, not {name!r}")
