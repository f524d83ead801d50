"""What the host gives the front end of cell traversal for one frustum: the tables of the grid rays, as payloads."""

from collections.abc import Iterable

from golden.engine.config import Config
from golden.engine.ctu.grid_rays import GridRays
from golden.engine.ctu.unit import CellTraversalUnit
from hw.ctu.ctu_formats import GRID_GROUP, CtuFormats, GridTableKind
from hw.lib.payload import pack

__all__ = ["GridAddresses", "grid_writes", "grouped", "unit_writes"]


class GridAddresses:
    """Where the rows, columns and rays of each shell are in the tables.

    Parameters
    ----------
    rays
        The grid rays of the shells, one after the other.

    Members
    -------
    first_row, first_column, first_ray
        By shell.
    """

    def __init__(self, rays: Iterable[GridRays]):
        self.first_row, self.first_column, self.first_ray = {}, {}, {}
        row = column = ray = 0
        for one in rays:
            self.first_row[one.shell], self.first_column[one.shell], self.first_ray[one.shell] = row, column, ray
            row, column, ray = row + one.rows, column + one.columns, ray + one.rows * one.columns

    def request(self, rays: GridRays, number: int) -> dict:
        """Of the ray ``number`` of a shell what a `CtuFormats.grid_request` says."""
        row, column = divmod(number, rays.columns)
        return {"shell": rays.shell, "ray": self.first_ray[rays.shell] + number,
                "row": self.first_row[rays.shell] + row, "column": self.first_column[rays.shell] + column, "count": 1}


def grouped(requests: Iterable[dict]) -> list[dict]:
    """Requests for rays alone as requests for up to `GRID_GROUP` neighbours, in the same order."""
    groups = []
    for request in requests:
        last = groups[-1] if groups else None
        if last and last["count"] < GRID_GROUP and all(
                last[name] == request[name] for name in ("shell", "row")) and all(
                last[name] + last["count"] == request[name] for name in ("ray", "column")):
            last["count"] += 1
        else:
            groups.append(dict(request))
    return groups


def grid_writes(rays: list[GridRays], config: Config, *, ways=None, thresholds=None) -> list[dict]:
    """The values of `CtuFormats.grid_table_write`.

    Parameters
    ----------
    rays
        The grid rays of the shells, from shell 2 on.
    ways, thresholds
        By shell: where it begins and ends, and its threshold; 0 without.
    """
    formats, addresses, writes = CtuFormats(config), GridAddresses(rays), []

    def write(kind, shape, index, **record):
        writes.append({"kind": kind.value, "index": index, "data": pack(shape, record)})

    for one in rays:
        shell = one.shell
        begin, end = ways[shell] if ways else (0, 0)
        write(GridTableKind.SHELL, formats.grid_shell, shell, begin=begin, length=end - begin,
              threshold=thresholds[shell] if thresholds else 0, row_border=one.row_border,
              first_row=addresses.first_row[shell], rows=one.rows, first_column=addresses.first_column[shell],
              columns=one.columns, first_ray=addresses.first_ray[shell])
        for k in range(one.rows):
            write(GridTableKind.ROW, formats.grid_row, addresses.first_row[shell] + k, table=_pair(one.row_table[k]),
                  position=one.row_position[k], first_near=one.first_row[k], near=one.row_count[k],
                  column_reach=one.column_reach[k], column_border=one.column_border[k])
        for k in range(one.columns):
            write(GridTableKind.COLUMN, formats.grid_column, addresses.first_column[shell] + k,
                  table=_pair(one.column_table[k]), position=one.column_position[k])
    return writes


def unit_writes(unit: CellTraversalUnit, config: Config) -> list[dict]:
    """The same of all shells of a frustum."""
    shells = range(2, unit.last_shell + 1)
    return grid_writes([unit.rays(shell) for shell in shells], config,
                       ways={shell: unit.borders(shell) for shell in shells},
                       thresholds={shell: unit.threshold(shell, config) for shell in shells})


def _pair(entry):
    """A table's entry; a screen's have one number."""
    return [int(entry[0]), int(entry[1]) if len(entry) > 1 else 0]
