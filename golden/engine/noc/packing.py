"""Packets of patch requests and of replies, flit by flit."""

from golden.engine.config import Config

__all__ = ["CHECK_BITS", "VERTICES", "check", "pack_flits", "reply_flits", "request_flits"]

# Check bits of a flit, by method.
CHECK_BITS = {"none": 0, "parity": 1, "crc": 8}
# x^8 + x^2 + x + 1, without the highest power.
CRC_POLYNOMIAL = 0x07
VERTICES = 4
_SURFACE_BITS = 32


def check(method: str, value: int, bits: int) -> int:
    """The check bits of a value: its parity, or the remainder of value x^8, highest bit first."""
    if method == "none":
        return 0
    if method == "parity":
        return value.bit_count() & 1
    remainder = 0
    for bit in reversed(range(bits)):
        out = (remainder >> 7 ^ value >> bit) & 1
        remainder = (remainder << 1 & 0xFF) ^ (CRC_POLYNOMIAL if out else 0)
    return remainder


def pack_flits(config: Config, parts: list[tuple[int, int]]) -> list[tuple[int, bool, bool]]:
    """The flits of a packet: data with check bits above it, first, last.

    ``parts`` are values and their numbers of bits. Each value begins a new flit and occupies as many as it needs,
    lowest bits first. The check covers the data with ``first`` and ``last`` above it.
    """
    width, method = config.noc.flit_bits, config.noc.check
    words = [value >> shift & (1 << width) - 1 for value, bits in parts for shift in range(0, bits, width)]
    flits = []
    for number, word in enumerate(words):
        first, last = number == 0, number == len(words) - 1
        checked = word | int(first) << width | int(last) << width + 1
        flits.append((word | check(method, checked, width + 2) << width, first, last))
    return flits


def request_flits(config: Config, *, source: int, destination: int, patch: int) -> list[tuple[int, bool, bool]]:
    """The flits of a request: destination, source and patch in one value, from the lowest bits."""
    return pack_flits(config, [_header(config, source, destination, patch)])


def reply_flits(config: Config, *, source: int, destination: int, patch: int, surface: int,
                vertices: list[tuple[int, int, int]]) -> list[tuple[int, bool, bool]]:
    """The flits of a reply: the value of a request with the surface above, then a value per vertex, x lowest."""
    header, bits = _header(config, source, destination, patch)
    header |= (surface & (1 << _SURFACE_BITS) - 1) << bits
    width = config.numbers.scene.width
    packed = [sum((part & (1 << width) - 1) << width * axis for axis, part in enumerate(vertex)) for vertex in vertices]
    return pack_flits(config, [(header, bits + _SURFACE_BITS), *((vertex, 3 * width) for vertex in packed)])


def _header(config, source, destination, patch):
    node = config.noc.node_bits
    return destination | source << node | patch << 2 * node, 2 * node + config.icu.patch_bits
