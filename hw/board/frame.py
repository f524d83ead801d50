"""How results are sent: frames of bytes."""

from amaranth.lib import enum
from amaranth.lib.crc.catalog import CRC32_ISO_HDLC

from golden.memory_map import MAGIC, REGIONS

__all__ = ["CHECK", "CHECK_BYTES", "HEADER_BYTES", "LENGTH_BITS", "FrameKind", "header", "region_kind"]

# zlib.crc32, of header and payload.
CHECK, CHECK_BYTES = CRC32_ISO_HDLC, 4
HEADER_BYTES, LENGTH_BITS = 8, 24


class FrameKind(enum.Enum, shape=8):
    """Kinds of frames that are no region of the image; smaller kinds are regions, in the order of the memory map."""

    CYCLES = 0x80
    ERROR = 0x81


def region_kind(name: str) -> int:
    """The kind of the frames of a region."""
    return [region.name for region in REGIONS].index(name)


def header(kind: int, length: int) -> int:
    """Magic number, kind, and bytes of the payload, as one number of `HEADER_BYTES`.

    Raises
    ------
    ValueError
        The payload is too long.
    """
    if not 0 <= length < 1 << LENGTH_BITS:
        raise ValueError(f"Length must be from 0 to {(1 << LENGTH_BITS) - 1}, not {length!r}")
    return MAGIC | kind << 32 | length << 40
