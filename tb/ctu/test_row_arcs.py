"""The arcs of each row hold golden's columns of the sector."""

from itertools import pairwise

import pytest

from golden.ctu.sector import sector_rays
from hw.ctu.row_arcs import RowArcs
from tb.ctu.grid_load import GridAddresses
from tb.ctu.window_stages import SECTORS, WindowStages
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = config_of({})
COMPONENT = RowArcs(config=CONFIG)
BENCH = ScheduleBench(COMPONENT)


@pytest.mark.parametrize(("kind", "sector"), [
    (kind, sector) for kind, sectors in SECTORS.items() for sector in range(len(sectors))])
def test_columns_of_the_sector(kind, sector):
    stages = WindowStages(kind, CONFIG, seed=sector, sector=sector, last_shell=5)
    addresses, rows = GridAddresses(stages.rays.values()), []
    for shell, rays in stages.rays.items():
        rows += [(shell, row, addresses.first_row[shell] + row) for row in range(rays.rows)]
    came = BENCH.run(Schedule(
        first={"i_table": stages.tables}, items={"i": [(2 * (not k), address) for k, (*_, address) in enumerate(rows)]},
        stalls={"o": [0] * 20 + [k % 5 for k in range(40)]}), frustum=stages.ports["frustum"])["o"]
    assert len(came) == len(rows)
    masks = {shell: sector_rays(rays, stages.sector, stages.record) for shell, rays in stages.rays.items()}
    for (shell, row, _), arcs in zip(rows, came, strict=True):
        position, whole_rows = stages.rays[shell].column_position, masks[shell].any(axis=1)
        held = (position >= arcs["low"]) & (position < arcs["end"])
        if arcs["wraps"]:
            held |= position < arcs["over"]
        # Rows outside the sector have no columns in golden.
        if whole_rows[row]:
            assert (held == masks[shell][row]).all(), (shell, row)
    cycles = BENCH.cycles
    assert cycles["o"][0] - cycles["i"][0] == COMPONENT.latency == documented_latency(RowArcs, CONFIG)
    assert {b - a for a, b in pairwise(cycles["o"][:20])} == {1}, "a row must come in each cycle"
