"""What docs/figures/ has recorded of the hardware."""

import csv
from typing import TypeVar, get_type_hints

from radiosity.flow.synthesis.history import ROOT

__all__ = ["read_rows"]

Row = TypeVar("Row")


def read_rows(name: str, kind: type[Row]) -> tuple[Row, ...]:
    """The rows of docs/figures/NAME.csv, as objects of a dataclass whose members are its columns."""
    types = get_type_hints(kind)
    with (ROOT / "docs" / "figures" / f"{name}.csv").open(newline="") as file:
        return tuple(kind(**{column: types[column](row[column]) for column in types}) for row in csv.DictReader(file))
