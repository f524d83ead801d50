import numpy as np
import pytest

from golden.engine.config import PRESETS
from golden.engine.noc.packing import CHECK_BITS, check, pack_flits

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
