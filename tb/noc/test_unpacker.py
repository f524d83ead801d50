import random
from itertools import cycle

import pytest
from amaranth.lib.data import StructLayout

from golden.engine.config import PRESETS
from golden.engine.noc.packing import check, pack_flits
from hw.lib.payload import pack, unpack
from hw.noc.network_fault import NetworkFault
from hw.noc.unpacker import Unpacker
from tb.lib.bench import Bench, Vectors
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stages import Gather

BITS, NODE, METHOD = 32, 5, "crc"
HEADER, BODY = StructLayout({"destination": 3, "source": 3, "number": 40}), StructLayout({"a": 20, "b": 13})
CONFIG = PRESETS["small"].replace({"noc.flit_bits": BITS, "noc.check": METHOD})


def flits(header, bodies):
    parts = [(pack(HEADER, header), HEADER.size), *((pack(BODY, body), BODY.size) for body in bodies)]
    return [{"data": data, "first": int(first), "last": int(last)} for data, first, last in pack_flits(CONFIG, parts)]


def make(bodies):
    return Unpacker(HEADER, BODY, bodies=bodies, bits=BITS, method=METHOD, node=NODE)


class TestUnpacker(Bench):
    """Items are those that were packed, each in the cycle of its last flit."""

    component, variants, splits, bodies = Unpacker, ({},), False, 2

    def make(self, config):
        return make(self.bodies)

    def vectors(self, config):
        draw = random.Random(4)
        packets = [tuple([unpack(shape, draw.getrandbits(shape.size)) for _ in range(count)]
                         for shape, count in ((HEADER, 1), (BODY, self.bodies))) for _ in range(30)]
        return Vectors(
            inputs={"i": [flit for (header,), given in packets for flit in flits(header, given)]},
            expected={"o": [{"header": header, "body": body} for (header,), given in packets
                            for body in given or [None]]})

    def stages(self, component, config):
        header, body = (-(-shape.size // BITS) for shape in (HEADER, BODY))
        return [Gather(cycle([header + body, *[body] * (self.bodies - 1)] if self.bodies else [header]))]


class TestRequests(TestUnpacker):
    bodies = 0


def faults(words):
    """The fault after each flit, when one is accepted in each cycle."""
    bench = ScheduleBench(make(2), watched=["fault"])
    bench.run(Schedule(items={"i": [(0, word) for word in words]}))
    return [NetworkFault(bench.history["fault"][cycle]) for cycle in bench.cycles["i"]]


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
