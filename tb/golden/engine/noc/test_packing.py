import numpy as np
import pytest

from golden.engine.config import PRESETS
from golden.engine.noc.packing import CHECK_BITS, check, pack_flits, reply_flits, request_flits

GENERATOR = np.random.default_rng(1)
WORDS = [int.from_bytes(GENERATOR.bytes(9)) >> 6 for _ in range(40)]


def config(flit_bits=32, method="crc", preset="small"):
    return PRESETS[preset].replace({"noc.flit_bits": flit_bits, "noc.check": method})


def remainder(value):
    """Of the division of value x^8 by x^8 + x^2 + x + 1, by long division of polynomials over two elements."""
    value <<= 8
    while value.bit_length() > 8:
        value ^= 0b1_0000_0111 << value.bit_length() - 9
    return value


def test_check_is_a_remainder_or_a_parity():
    for value in (0, 1, 1 << 65, (1 << 66) - 1, *WORDS):
        assert check("crc", value, 66) == remainder(value)
        assert check("parity", value, 66) == f"{value:b}".count("1") % 2
        assert check("none", value, 66) == 0


def test_crc_is_that_of_the_catalogue():
    """CRC-8/SMBUS of the nine digits."""
    assert check("crc", int.from_bytes(b"123456789"), 72) == 0xF4


@pytest.mark.parametrize("method", ["parity", "crc"])
def test_every_single_error_is_noticed(method):
    for value in WORDS[:8]:
        assert all(check(method, value ^ 1 << bit, 66) != check(method, value, 66) for bit in range(66))


def test_every_error_of_up_to_eight_neighbours_is_noticed_by_the_crc():
    for value in WORDS[:4]:
        for length in range(1, 9):
            burst = (1 << length) - 1
            assert all(check("crc", value ^ burst << bit, 66) != check("crc", value, 66) for bit in range(66 - length))


@pytest.mark.parametrize("method", CHECK_BITS)
@pytest.mark.parametrize("width", [16, 32])
def test_values_come_back(width, method):
    parts = [(0x1_2345_6789, 33), (5, 3), (WORDS[0], 66)]
    flits = pack_flits(config(width, method), parts)
    lengths = [-(-bits // width) for _, bits in parts]
    assert [first for _, first, _ in flits] == [True] + [False] * (sum(lengths) - 1)
    assert [last for _, _, last in flits] == [False] * (sum(lengths) - 1) + [True]
    words = [data % (1 << width) for data, *_ in flits]
    for (value, bits), length in zip(parts, lengths, strict=True):
        mine, words = words[:length], words[length:]
        assert sum(word << width * index for index, word in enumerate(mine)) == value % (1 << bits)
    for data, first, last in flits:
        checked = data % (1 << width) + (first << width) + (last << width + 1)
        expected = {"none": 0, "parity": f"{checked:b}".count("1") % 2, "crc": remainder(checked)}[method]
        assert data >> width == expected


def test_requests_and_replies_hold_their_fields():
    given = config(method="none")
    node, patch_bits, width = given.noc.node_bits, given.icu.patch_bits, given.numbers.scene.width
    whole = 0
    request = request_flits(given, source=1, destination=2 % (1 << node), patch=77)
    for index, (data, *_) in enumerate(request):
        whole |= data << 32 * index
    assert whole % (1 << node) == 2 % (1 << node)
    assert whole >> node & (1 << node) - 1 == 1
    assert whole >> 2 * node == 77
    vertices = [(1, -2, 3), (-4, 5, -6), (0, 0, -1), (7, 8, 9)]
    reply = reply_flits(given, source=1, destination=0, patch=77, surface=0xFEDC_BA98, vertices=vertices)
    words = [data for data, *_ in reply]
    header, words = words[:-(-(2 * node + patch_bits + 32) // 32)], words[-(-(2 * node + patch_bits + 32) // 32):]
    assert sum(word << 32 * k for k, word in enumerate(header)) >> 2 * node + patch_bits == 0xFEDC_BA98
    each = -(-3 * width // 32)
    assert len(words) == 4 * each
    for number, vertex in enumerate(vertices):
        value = sum(word << 32 * k for k, word in enumerate(words[number * each:(number + 1) * each]))
        parts = [value >> width * axis & (1 << width) - 1 for axis in range(3)]
        assert tuple(part - (part >> width - 1 << width) for part in parts) == vertex
