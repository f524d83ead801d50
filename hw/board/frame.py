"""How results are sent: frames of bytes."""

from amaranth.lib import enum
from amaranth.lib.crc.catalog import CRC32_ISO_HDLC

from golden.engine.memory_map import MAGIC

__all__ = ["CHECK", "CHECK_BYTES", "HEADER_BYTES", "LENGTH_BITS", "FrameKind", "header"]

# zlib.crc32, of header and payload.
CHECK, CHECK_BYTES = CRC32_ISO_HDLC, 4
HEADER_BYTES, LENGTH_BITS = 8, 24


class FrameKind(enum.Enum, shape=8):
    """Kinds of frames."""

    DESCRIPTORS = 0x80
    COMPLETIONS = 0x81
    HITS = 0x82
    ERROR = 0xFF


def header(kind: FrameKind, length: int) -> int:
    """Magic number, kind, and bytes of the payload, as one number of `HEADER_BYTES`.

    Raises
    ------
    ValueError
        The payload is too long.
    """
    if not 0 <= length < 1 << LENGTH_BITS:
        raise ValueError(f"Length must be from 0 to {(1 << LENGTH_BITS) - 1}, not {length!r}")
    return MAGIC | kind.value << 32 | length << 40
