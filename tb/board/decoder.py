"""What the board has sent: frames, and the picture in them."""

import zlib
from dataclasses import dataclass

import numpy as np

from golden.errors import InputError
from golden.image import label_colours
from golden.memory_map import MAGIC, REGIONS
from hw.board.frame import CHECK_BYTES, HEADER_BYTES, FrameKind, header
from hw.host import EngineError
from hw.registers.error_code import ErrorCode
from hw.registers.register import WORD_BYTES

__all__ = ["Frame", "encode", "frames", "hit_picture", "results"]

_MAGIC = MAGIC.to_bytes(4, "little")


@dataclass(frozen=True)
class Frame:
    """Kind and payload."""

    kind: int
    payload: bytes


def frames(data: bytes) -> list[Frame]:
    """All whole frames among bytes; what does not begin with the magic number, or has a wrong checksum, is skipped."""
    found, at = [], 0
    while (at := data.find(_MAGIC, at)) >= 0:
        kind, length = data[at + 4:at + 5], int.from_bytes(data[at + 5:at + HEADER_BYTES], "little")
        end = at + HEADER_BYTES + length
        check = data[end:end + CHECK_BYTES]
        if len(check) == CHECK_BYTES and zlib.crc32(data[at:end]) == int.from_bytes(check, "little"):
            found.append(Frame(kind[0], data[at + HEADER_BYTES:end]))
            at = end + CHECK_BYTES
        else:
            at += 1
    return found


def encode(frame: Frame) -> bytes:
    """The bytes of a frame."""
    data = header(frame.kind, len(frame.payload)).to_bytes(HEADER_BYTES, "little") + frame.payload
    return data + zlib.crc32(data).to_bytes(CHECK_BYTES, "little")


def results(given: list[Frame]) -> tuple[int, dict[str, np.ndarray]]:
    """Cycles of the last cast, and the regions that came with it.

    Raises
    ------
    EngineError
        It has ended with one.
    InputError
        There is none.
    """
    cycles, regions = None, {}
    for frame in given:
        if frame.kind == FrameKind.ERROR.value:
            words = np.frombuffer(frame.payload, "<u4").tolist()
            raise EngineError(ErrorCode(words[0]), words[1], words[2] | words[3] << 8 * WORD_BYTES)
        if frame.kind == FrameKind.CYCLES.value:
            cycles, regions = int.from_bytes(frame.payload, "little"), {}
        else:
            region = REGIONS[frame.kind]
            regions[region.name] = np.frombuffer(frame.payload, region.dtype)
    missing = [name for name in ("frustum", "hits", "sums") if name not in regions]
    if cycles is None or missing:
        raise InputError("board: There must be a whole cast among what was sent; there is no frame of "
                         f"{', '.join(['cycles'] * (cycles is None) + missing)}")
    return cycles, regions


def hit_picture(regions: dict[str, np.ndarray]) -> np.ndarray:
    """H x W x 3 uint8: a colour for each patch."""
    (frustum,) = regions["frustum"]
    return label_colours(regions["hits"]["patch"].reshape(int(frustum["rows"]), int(frustum["columns"])))
