import random

import pytest

from golden.config import PRESETS
from hw.control.near_cell_banks import NearCellBanks
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"ctu.near_cell_bits": 5})
DUT = NearCellBanks(config=CONFIG)
BENCH = ScheduleBench(DUT)


@pytest.mark.parametrize("most", [0, 4])
@pytest.mark.parametrize("counts", [(5, 0, 1, 32), (32, 31, 2)])
def test_cells_of_a_bank_are_sent_for_every_section(counts, most):
    draw = random.Random(most)
    cells = [[draw.getrandbits(24) for _ in range(32)] for _ in range(2)]
    first = [{"bank": bank, "address": k, "cells": cells[bank][2 * k] | cells[bank][2 * k + 1] << 24}
             for bank in range(2) for k in range(16)]
    commands = [{"bank": k % 2, "count": count} for k, count in enumerate(counts)]
    came = BENCH.run(Schedule(items={"i": [(0, one) for one in commands]}, first={"i_load": first},
                              stalls={"o": [draw.randint(0, most) for _ in range(100)]}))["o"]
    assert [(one["cell"] if one["is_cell"] else None, one["last"]) for one in came] == [
        (cells[k % 2][n] if count else None, int(n == max(count, 1) - 1))
        for k, count in enumerate(counts) for n in range(max(count, 1))]
    if not most:
        begin = BENCH.cycles["i"][0] + DUT.latency
        assert DUT.latency == documented_latency(NearCellBanks, CONFIG)
        assert BENCH.cycles["o"][:counts[0]] == list(range(begin, begin + counts[0]))


def test_a_bank_is_loaded_while_the_other_one_is_sent():
    """The words of the next section come at full rate."""
    old, new = ([7 * k + base for k in range(32)] for base in (1, 1000))
    loads = [[{"bank": bank, "address": k, "cells": cells[2 * k] | cells[2 * k + 1] << 24} for k in range(16)]
             for bank, cells in enumerate((old, new))]
    commands = [(0, {"bank": bank, "count": 32}) for bank in range(2)]
    came = BENCH.run(Schedule(items={"i_load": [(0, one) for one in loads[1]], "i": commands},
                              first={"i_load": loads[0]}))["o"]
    assert [one["cell"] for one in came] == old + new
