from itertools import pairwise

import pytest
from amaranth.lib.data import StructLayout
from hypothesis import given
from hypothesis import strategies as st

from golden.config import PRESETS
from golden.noc.packing import check, pack_flits
from hw.noc.network_fault import NetworkFault
from hw.noc.unpacker import Unpacker
from tb.lib.payload import pack
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, payloads, schedules

BITS, NODE, METHOD = 32, 5, "crc"
HEADER, BODY = StructLayout({"destination": 3, "source": 3, "number": 40}), StructLayout({"a": 20, "b": 13})
CONFIG = PRESETS["small"].replace({"noc.flit_bits": BITS, "noc.check": METHOD})
PACKET = st.tuples(payloads(HEADER), st.lists(payloads(BODY), min_size=2, max_size=2))


def flits(header, bodies):
    parts = [(pack(HEADER, header), HEADER.size), *((pack(BODY, body), BODY.size) for body in bodies)]
    return [{"data": data, "first": int(first), "last": int(last)} for data, first, last in pack_flits(CONFIG, parts)]


def make(bodies):
    return Unpacker(HEADER, BODY, bodies=bodies, bits=BITS, method=METHOD, node=NODE)


@pytest.mark.parametrize("bodies", [0, 2])
def test_items_are_those_that_were_packed(bodies):
    bench = ScheduleBench(make(bodies), ["i"], ["o"])

    @SETTINGS
    @given(st.lists(PACKET, max_size=4), schedules({}, ["i", "o"]))
    def run(packets, schedule):
        words = [flit for header, given_bodies in packets for flit in flits(header, given_bodies[:bodies])]
        idle = iter(schedule.stalls["i"])
        found = bench.run(Schedule(items={"i": [(next(idle, 0), word) for word in words]},
                                   stalls={"o": schedule.stalls["o"]}))["o"]
        assert [item["header"] for item in found] == [header for header, _ in packets for _ in range(max(1, bodies))]
        if bodies:
            assert [item["body"] for item in found] == [body for _, both in packets for body in both]

    run()


def faults(words):
    """The fault after each flit, when one is accepted in each cycle."""
    dut, found = make(2), []
    bench = ScheduleBench(dut, ["i"], ["o"])

    async def watch(ctx):
        async for *_, valid, ready, fault in ctx.tick().sample(dut.i.valid, dut.i.ready, dut.fault):
            found.append((valid & ready, fault))

    bench._simulator.add_process(watch)
    bench.run(Schedule(items={"i": [(0, word) for word in words]}, stalls={"o": []}))
    return [after for (moves, _), (_, after) in pairwise(found) if moves]


HEADERS = {"destination": NODE, "source": 1, "number": 3}
GOOD = flits(HEADERS, [{"a": 1, "b": 2}, {"a": 3, "b": 4}])


def test_a_good_packet_has_no_fault():
    assert faults(GOOD * 2) == [NetworkFault.NONE] * 2 * len(GOOD)


@pytest.mark.parametrize("position", range(len(GOOD)))
def test_a_wrong_bit_is_a_fault_of_the_check(position):
    words = [dict(word) for word in GOOD]
    words[position]["data"] ^= 1 << 7
    assert faults(words)[position] == NetworkFault.CHECK


def test_another_destination_is_a_fault():
    words = flits(HEADERS | {"destination": NODE ^ 1}, [{"a": 1, "b": 2}, {"a": 3, "b": 4}])
    found = faults(words)
    assert found.count(NetworkFault.ADDRESS) == 1
    # It is known with the last flit of the header.
    assert found.index(NetworkFault.ADDRESS) == -(-HEADER.size // BITS) - 1


@pytest.mark.parametrize(("words", "at"), [(GOOD[:-1] + GOOD, len(GOOD) - 1), (GOOD[1:], 0)])
def test_a_flit_out_of_order_is_a_fault(words, at):
    assert faults(words)[at] == NetworkFault.ORDER


@pytest.mark.parametrize("position", [1, len(GOOD) - 2, len(GOOD) - 1])
def test_a_wrong_mark_of_the_last_flit_is_a_fault(position):
    """Its check is right: the sender has marked it so."""
    words = [dict(word) for word in GOOD]
    flit = words[position]
    flit["last"] ^= 1
    data = flit["data"] & (1 << BITS) - 1
    flit["data"] = data | check(METHOD, data | flit["first"] << BITS | flit["last"] << BITS + 1, BITS + 2) << BITS
    found = faults(words)
    assert found[position] == NetworkFault.ORDER
    assert found.count(NetworkFault.NONE) == len(GOOD) - 1


def test_a_new_packet_within_a_packet_is_read():
    bench = ScheduleBench(make(2), ["i"], ["o"])
    found = bench.run(Schedule(items={"i": [(0, word) for word in GOOD[:3] + GOOD]}, stalls={"o": []}))["o"]
    assert [item["body"] for item in found][-2:] == [{"a": 1, "b": 2}, {"a": 3, "b": 4}]
