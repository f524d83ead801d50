import pytest
from amaranth.lib.data import StructLayout
from hypothesis import given

from golden.config import PRESETS
from golden.noc.packing import CHECK_BITS, pack_flits
from hw.noc.packer import Packer
from tb.lib.payload import pack
from tb.lib.schedules import SETTINGS, ScheduleBench, payloads, schedules

BITS = 32
HEADER, BODY = StructLayout({"destination": 3, "source": 3, "number": 40}), StructLayout({"a": 20, "b": 13})
# Bodies of a packet, check.
CASES = [(0, "crc"), (1, "none"), (3, "parity")]


def packets(items, bodies, method):
    """The flits of items, each packet with the header of its items."""
    config, flits = PRESETS["small"].replace({"noc.flit_bits": BITS, "noc.check": method}), []
    group = max(1, bodies)
    for first in range(0, len(items) - group + 1, group):
        parts = [(pack(HEADER, items[first]["header"]), HEADER.size)]
        parts += [(pack(BODY, item["body"]), BODY.size) for item in items[first:first + bodies]]
        flits += [{"data": data, "first": int(start), "last": int(end)}
                  for data, start, end in pack_flits(config, parts)]
    return flits


@pytest.mark.parametrize(("bodies", "method"), CASES)
def test_flits_are_those_of_golden(bodies, method):
    bench = ScheduleBench(Packer(HEADER, BODY, bodies=bodies, bits=BITS, method=method), ["i"], ["o"])
    item = payloads(StructLayout({"header": HEADER, "body": BODY}))

    @SETTINGS
    @given(schedules({"i": item}, ["o"]))
    def check(schedule):
        # Items of one packet have one header.
        for index, (_, value) in enumerate(schedule.items["i"]):
            value["header"] = schedule.items["i"][index - index % max(1, bodies)][1]["header"]
        expected = packets(schedule.values("i"), bodies, method)
        found = bench.run(schedule)["o"]
        # The remaining flits are of an incomplete packet.
        assert found[:len(expected)] == expected
        assert sum(one["last"] for one in found) == sum(one["last"] for one in expected)

    check()


def test_cases_are_all_checks():
    assert {method for _, method in CASES} == CHECK_BITS.keys()
