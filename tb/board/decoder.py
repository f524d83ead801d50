"""What the board has sent: frames, and the picture in them."""

import zlib
from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.jobs.completion import parse_completions
from golden.engine.jobs.descriptor import DESCRIPTOR, Kind
from golden.engine.jobs.result_formats import HitFormat, unpack_hits
from golden.engine.memory_map import MAGIC
from golden.light.image import label_colours
from hw.board.frame import CHECK_BYTES, HEADER_BYTES, FrameKind, header
from hw.registers.error_code import ErrorCode
from hw.registers.register import WORD_BYTES
from radiosity.flow.host import EngineError

__all__ = ["Cast", "Frame", "encode", "frames", "hit_picture", "results"]

_MAGIC = MAGIC.to_bytes(4, "little")
_PARTS = (FrameKind.COMPLETIONS, FrameKind.DESCRIPTORS, FrameKind.HITS)


@dataclass(frozen=True)
class Frame:
    """Kind and payload."""

    kind: FrameKind
    payload: bytes


@dataclass(frozen=True, kw_only=True, eq=False)
class Cast:
    """A whole cast.

    Parameters
    ----------
    columns, rows
        Rays.
    hits
        Their hits.
    completions
        The records of `golden.engine.jobs.completion.COMPLETION` of all descriptors.
    cycles
        From the beginning of the first section to the end of the last one.
    """

    columns: int
    rows: int
    hits: FixedHits
    completions: np.ndarray
    cycles: int


def frames(data: bytes) -> list[Frame]:
    """All whole frames among bytes; what does not begin with the magic number, or has a wrong checksum, is skipped."""
    found, at, kinds = [], 0, {kind.value: kind for kind in FrameKind}
    while (at := data.find(_MAGIC, at)) >= 0:
        kind, length = data[at + 4:at + 5], int.from_bytes(data[at + 5:at + HEADER_BYTES], "little")
        end = at + HEADER_BYTES + length
        check = data[end:end + CHECK_BYTES]
        if (len(check) == CHECK_BYTES and zlib.crc32(data[at:end]) == int.from_bytes(check, "little")
                and kind[0] in kinds):
            found.append(Frame(kinds[kind[0]], data[at + HEADER_BYTES:end]))
            at = end + CHECK_BYTES
        else:
            at += 1
    return found


def encode(frame: Frame) -> bytes:
    """The bytes of a frame."""
    data = header(frame.kind, len(frame.payload)).to_bytes(HEADER_BYTES, "little") + frame.payload
    return data + zlib.crc32(data).to_bytes(CHECK_BYTES, "little")


def results(given: list[Frame]) -> Cast:
    """The last cast.

    Raises
    ------
    EngineError
        It, or one of its descriptors, has ended with one.
    InputError
        There is none.
    """
    parts = {}
    for frame in given:
        if frame.kind == FrameKind.ERROR:
            words = np.frombuffer(frame.payload, "<u4").tolist()
            raise EngineError(ErrorCode(words[0]), words[1], words[2] | words[3] << 8 * WORD_BYTES)
        if frame.kind == FrameKind.COMPLETIONS:
            parts = {}
        parts[frame.kind] = frame.payload
    missing = [kind.name.lower() for kind in _PARTS if kind not in parts]
    if missing:
        raise InputError("board: There must be a whole cast among what was sent; there is no frame of "
                         f"{', '.join(missing)}")
    descriptors = np.frombuffer(parts[FrameKind.DESCRIPTORS], dtype=DESCRIPTOR.dtype)
    completions = parse_completions(parts[FrameKind.COMPLETIONS])[:len(descriptors)]
    for one in completions[completions["error"] != 0]:
        raise EngineError(ErrorCode(int(one["error"])), int(one["cluster"]), int(one["address"]))
    sections = descriptors[descriptors["kind"] == Kind.FRUSTUM]
    cast = completions[np.isin(completions["tag"], sections["tag"])]
    return Cast(columns=int(sections["columns"][0]), rows=int(sections["rows"][0]), completions=completions,
                hits=unpack_hits(parts[FrameKind.HITS], HitFormat(sections["hit_format"][0])),
                cycles=(int(cast["end"][-1]) - int(cast["begin"][0])) % (1 << 32))


def hit_picture(cast: Cast) -> np.ndarray:
    """H x W x 3 uint8: a colour for each patch."""
    return label_colours(cast.hits.patch.reshape(cast.rows, cast.columns))
