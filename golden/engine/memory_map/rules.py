"""The rules of a memory image's records that host and machine check: of each record by itself, with its tables."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from golden.engine.memory_map.layout import EVERY_CLUSTER, GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS, WEIGHT_BITS

__all__ = ["RULES", "Rule", "RuleKind"]


class RuleKind(enum.Enum):
    """What must hold of the numbers of a record; the values are the code of a load that finds a record without it, and
    what a page says.

    ``BELOW``: a < records of the table. ``MAYBE``: so, or -1 for none, or -2 for all. ``RANGE``: a + b <= records.
    ``SMALL``: a < 2^`GRID_SHAPE_BITS`. ``GRID``: rows and columns of a shell < 2^`GRID_SIDE_BITS` and first_ray + rows
    columns <= 2^`GRID_RAY_BITS`. ``WEIGHT``: a < 2^`WEIGHT_BITS`. ``QUAD``: a = 0.
    """

    BELOW = "POINTER", "below the number of records of `{table}`"
    MAYBE = "POINTER", f"{EVERY_CLUSTER} to the number of records of `{{table}}` - 1"
    RANGE = "POINTER", "together at most the number of records of `{table}`"
    SMALL = "SIZE", f"below {1 << GRID_SHAPE_BITS}"
    GRID = "SIZE", (f"`rows` and `columns` below {1 << GRID_SIDE_BITS}, `first_ray` + `rows` x `columns` at most "
                    f"{1 << GRID_RAY_BITS}")
    WEIGHT = "SIZE", f"below 2^{WEIGHT_BITS}"
    QUAD = "SIZE", "0"

    @property
    def code(self) -> str:
        """Of the load."""
        return self.value[0]


@dataclass(frozen=True)
class Rule:
    """A rule of a record.

    Parameters
    ----------
    region, fields
        The fields that it is about.
    kind
        The rule.
    table
        The region that they point into, or the own one.
    """

    region: str
    fields: tuple[str, ...]
    kind: RuleKind
    table: str

    @property
    def about(self) -> str:
        """What the fields must be, as a page says it."""
        return self.kind.value[1].format(table=self.table)

    def holds(self, image: Mapping[str, np.ndarray]) -> np.ndarray:
        """Whether each record of an image, an array of records per region, has it: N bool."""
        records, count = image[self.region], len(image[self.table])
        values = [records[name] if name == "cluster" else records[name].astype(np.uint64) for name in self.fields]
        if self.kind is RuleKind.GRID:
            rows, columns = (records[name].astype(np.uint64) for name in ("rows", "columns"))
            small = (rows | columns) < 1 << GRID_SIDE_BITS
            return small & (values[0] + rows * columns <= 1 << GRID_RAY_BITS)
        return {RuleKind.BELOW: lambda a: a < count, RuleKind.MAYBE: lambda a: (a >= EVERY_CLUSTER) & (a < count),
                RuleKind.RANGE: lambda a, b: a + b <= count,
                RuleKind.SMALL: lambda a: (a < 1 << GRID_SHAPE_BITS).all(axis=1),
                RuleKind.WEIGHT: lambda a: a < 1 << WEIGHT_BITS, RuleKind.QUAD: lambda a: a == 0}[self.kind](*values)

    def requirement(self, image: Mapping[str, np.ndarray]) -> str:
        """What a message says of an image that breaks it."""
        name, count = f"{self.region}.{self.fields[0]}", len(image[self.table])
        if self.kind is RuleKind.SMALL:
            return f"{name} must be below {1 << GRID_SHAPE_BITS}, not {image[self.region][self.fields[0]][0].tolist()}"
        return {RuleKind.BELOW: f"{name} must be below {count}",
                RuleKind.MAYBE: f"{name} must be {EVERY_CLUSTER} to {count - 1}",
                RuleKind.RANGE: f"{self.region} must point into the {count} records of {self.table}",
                RuleKind.WEIGHT: f"{name} must be below {1 << WEIGHT_BITS}",
                RuleKind.QUAD: f"{name} must be 0"}[self.kind]


def _rule(kind, region, *fields, table=None):
    return Rule(region, fields, kind, table or region)


RULES = (
    _rule(RuleKind.SMALL, "cell_grid", "shape"),
    _rule(RuleKind.RANGE, "cells", "pointer", "count", table="patch_lists"),
    _rule(RuleKind.BELOW, "patch_lists", "patch", table="patches"),
    _rule(RuleKind.BELOW, "patches", "id"),
    _rule(RuleKind.QUAD, "patches", "kind"),
    _rule(RuleKind.MAYBE, "residence", "cluster", table="clusters"),
    _rule(RuleKind.RANGE, "clusters", "first_subshell", "subshells", table="subshells"),
    _rule(RuleKind.RANGE, "clusters", "first_resident", "residents", table="residents"),
    _rule(RuleKind.BELOW, "subshells", "patch", table="patches"),
    _rule(RuleKind.BELOW, "residents", "patch", table="patches"),
    _rule(RuleKind.WEIGHT, "rows", "weight"),
    _rule(RuleKind.RANGE, "shells", "first_row", "rows", table="grid_rows"),
    _rule(RuleKind.RANGE, "shells", "first_column", "columns", table="grid_columns"),
    _rule(RuleKind.GRID, "shells", "first_ray", "rows", "columns"))
