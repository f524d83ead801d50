"""The record after the last sum: the total less all sums, whatever the total is."""

import pytest

from golden.config import PRESETS
from hw.icu.icu_formats import WEIGHT_SUM_BITS
from hw.memsys.fault import Fault
from hw.memsys.result_formats import ResultKind
from hw.memsys.write_dma import WriteDma
from tb.lib.responder import responder
from tb.lib.schedules import Schedule, ScheduleBench

CONFIG = PRESETS["tiny"]
LARGEST = (1 << WEIGHT_SUM_BITS) - 1
ADDRESS = 4096


@responder("o_request", "i_written", after=30)
def written(request):
    """Memory has stored the words by then."""
    return [{"error": 0}]


@pytest.fixture(scope="module")
def bench():
    return ScheduleBench(WriteDma(config=CONFIG), idle_limit=60)


@pytest.mark.parametrize("sums", [[0], [5], [5, 0, 7], [LARGEST], [LARGEST, 1], [1 << 42] * 4])
@pytest.mark.parametrize("total", [0, 1, 11, 12, 13, LARGEST])
def test_rest(bench, sums, total):
    items = [(0, {"patch": patch, "sum": value, "last": patch == len(sums) - 1}) for patch, value in enumerate(sums)]
    command = {"kind": ResultKind.SUMS.value, "address": ADDRESS, "count": len(sums) + 1, "total": total}
    came = bench.run(Schedule(items={"i": [(0, command)], "i_sum": items}), written)
    assert [one["code"] for one in came["o_done"]] == [Fault.NONE.value]
    assert [one["data"] for one in came["o_data"]] == [*sums, (total - sum(sums)) % (1 << WEIGHT_SUM_BITS)]
    assert {one["strobe"] for one in came["o_data"]} == {0xFF}
