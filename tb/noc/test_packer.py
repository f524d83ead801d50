import random

from amaranth.hdl import Shape
from amaranth.lib.data import StructLayout

from golden.engine.config import PRESETS
from golden.engine.noc.packing import CHECK_BITS, pack_flits
from hw.lib.payload import pack, unpack
from hw.noc.packer import Packer
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Expand

BITS = 32
HEADER, BODY = StructLayout({"destination": 3, "source": 3, "number": 40}), StructLayout({"a": 20, "b": 13})
PACKETS = 30


def flits_of(header, bodies, method):
    """The flits of a packet."""
    config = PRESETS["small"].replace({"noc.flit_bits": BITS, "noc.check": method})
    parts = [(pack(HEADER, header), HEADER.size), *((pack(BODY, body), BODY.size) for body in bodies)]
    return [{"data": data, "first": int(first), "last": int(last)} for data, first, last in pack_flits(config, parts)]


class TestPacker(Bench):
    """Packets of a header and a body."""

    component, variants, splits = Packer, ({},), False
    arguments = {"header": HEADER, "body": BODY, "bodies": 1, "bits": BITS, "method": "none"}

    def vectors(self, config):
        draw, bodies = random.Random(3), self.arguments["bodies"]

        def value(shape, number):
            """All zeros, all ones, or drawn."""
            width = Shape.cast(shape).width
            return unpack(shape, (0, (1 << width) - 1, draw.getrandbits(width))[min(number, 2)])

        packets = [(value(HEADER, k), [value(BODY, k) for _ in range(bodies)]) for k in range(PACKETS)]
        return Vectors(
            inputs={"i": [{"header": header, "body": body} for header, given in packets for body in given or [{}]]},
            expected={"o": [flit for header, given in packets
                            for flit in flits_of(header, given, self.arguments["method"])]})

    def stages(self, component, config):
        """An item is accepted with its last flit; those of the header are of the first item of a packet."""
        header, body = (-(-shape.size // BITS) for shape in (HEADER, BODY))
        bodies = self.arguments["bodies"]
        packet = [header + body, *[body] * (bodies - 1)] if bodies else [header]
        return [Expand(packet * PACKETS, holds=True)]


class TestRequests(TestPacker):
    arguments = {**TestPacker.arguments, "bodies": 0, "method": "crc"}


class TestReplies(TestPacker):
    arguments = {**TestPacker.arguments, "bodies": 3, "method": "parity"}


def test_all_checks_are_tried():
    assert {bench.arguments["method"] for bench in (TestPacker, TestRequests, TestReplies)} == CHECK_BITS.keys()
