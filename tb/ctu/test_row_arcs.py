"""The arcs of each row hold golden's columns of the sector."""

from functools import partial

from golden.engine.ctu.sector import sector_rays
from hw.ctu.row_arcs import RowArcs
from radiosity.flow.package.example.grid_load import GridAddresses
from tb.ctu.window_stages import SECTORS, WindowStages
from tb.lib.bench import Bench, Vectors


def of_sector(kind, sector, config):
    """All rows of some shells; in ``about`` each row's positions of columns, and which of them golden has."""
    stages = WindowStages(kind, config, seed=sector, sector=sector, last_shell=5)
    addresses, items, about = GridAddresses(stages.rays.values()), [], []
    for shell, rays in stages.rays.items():
        mask = sector_rays(rays, stages.sector, stages.record)
        items += [addresses.first_row[shell] + row for row in range(rays.rows)]
        about += [(rays.column_position, columns) for columns in mask]
    return Vectors(inputs={"i": items}, expected={"o": [None] * len(items)}, first={"i_table": stages.tables},
                   ports={"frustum": stages.ports["frustum"]}, about=about)


class TestRowArcs(Bench):
    component, variants, splits = RowArcs, ({},), False
    cases = {f"{kind} {sector}": partial(of_sector, kind, sector)
             for kind, sectors in SECTORS.items() for sector in range(len(sectors))}

    def check(self, given, came):
        super().check(given, came)
        for number, (arcs, (position, columns)) in enumerate(zip(self.values("o", came), given.about, strict=True)):
            held = (position >= arcs["low"]) & (position < arcs["end"])
            if arcs["wraps"]:
                held |= position < arcs["over"]
            # Rows outside the sector have no columns in golden.
            assert not columns.any() or (held == columns).all(), f"row {number}"
