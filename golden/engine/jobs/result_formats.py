"""What a cluster writes of a section: hits of 16, 8 or 4 bytes, or a bit for each ray of a list; and sums as words of
what is not 0.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from golden.base.errors import InputError
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.icu.patch_sums import SUM_BITS
from golden.engine.memory_map.layout import Field, Region

__all__ = ["FULL_HIT", "NO_PATCH", "PATCH_SHIFT", "HitFormat", "ResultCommand", "bit_words",
           "check_config", "exceeding", "pack_bits", "pack_hits", "pack_sums", "result_beats", "result_bytes",
           "scatter_sums", "section_rays", "unpack_bits", "unpack_hits", "unpack_ids", "unpack_sums"]


class HitFormat(IntEnum):
    """The record of a ray's hit."""

    NONE = 0
    FULL = 1
    COMPACT = 2
    IDS = 3

    @property
    def bytes(self) -> int:
        """Bytes of a record."""
        return (0, 16, 8, 4)[self]


FULL_HIT = Region("hit", "job", "ray", "The nearest hit of a ray.", (
    Field("inverse", "u4", "stored inverse distance, 0: no hit"),
    Field("patch", "i4", "patch id, -1: no hit"),
    Field("u", "u2", "position on the patch"),
    Field("v", "u2", "position on the patch"),
    Field("reserved", "u4", "0"),
))
# Of a record of 8 bytes: bits and first bit of each field. The patch of a ray without a hit is all ones.
_COMPACT = {"inverse": (24, 0), "patch": (24, 24), "u": (8, 48), "v": (8, 56)}
# Of a record of 4 bytes of a ray without a hit.
NO_PATCH = 0xFFFFFFFF
# A word of sums: the sum below, the patch above.
PATCH_SHIFT = SUM_BITS
_SUM_PATCH_BITS = 64 - PATCH_SHIFT


def exceeding(config: Config, hit_format: HitFormat, *, sums: bool) -> list[tuple[str, int, int, str]]:
    """What of a configuration has more bits than a format: of numbers their name, their bits, those of the format and
    its name.
    """
    numbers, icu, widths = config.numbers, config.icu, []
    if hit_format == HitFormat.COMPACT:
        widths += [(name, bits, _COMPACT[field][0], "hits of 8 bytes") for name, bits, field in (
            ("stored inverse distances", numbers.inverse.width, "inverse"), ("u and v", icu.uv_bits, "u"),
            ("patch ids", icu.patch_bits, "patch"))]
    if sums:
        widths.append(("patch ids", icu.patch_bits, _SUM_PATCH_BITS, "sums"))
    return [one for one in widths if one[1] > one[2]]


def check_config(config: Config, hit_format: HitFormat, *, sums: bool) -> None:
    """Refuse results that do not fit their formats.

    Raises
    ------
    InputError
        Numbers of the configuration have more bits than the format.
    """
    for name, bits, most, where in exceeding(config, hit_format, sums=sums):
        raise InputError(f"results: {name.capitalize()} must have at most {most} bits in {where}, not {bits}")


def pack_hits(hits: FixedHits, hit_format: HitFormat) -> np.ndarray:
    """The records of hits: R x ``hit_format.bytes`` uint8.

    Raises
    ------
    InputError
        A number has more bits than its field, or a patch's id is that of no hit.
    """
    if hit_format == HitFormat.NONE:
        return np.zeros((len(hits.patch), 0), dtype=np.uint8)
    if hit_format == HitFormat.FULL:
        records = np.zeros(len(hits.patch), dtype=FULL_HIT.dtype)
        for name in "inverse", "patch", "u", "v":
            records[name] = _within(name, getattr(hits, name), 31 if name == "patch" else 8 * records[name].itemsize)
    elif hit_format == HitFormat.COMPACT:
        records = np.zeros(len(hits.patch), dtype="<u8")
        for name, (bits, first) in _COMPACT.items():
            value = _within(name, getattr(hits, name), bits)
            records |= (value.astype(np.uint64) & np.uint64((1 << bits) - 1)) << np.uint64(first)
    else:
        records = (_within("patch", hits.patch, 32) & NO_PATCH).astype("<u4")
    return records.view(np.uint8).reshape(len(hits.patch), hit_format.bytes)


def _within(name, values, bits):
    """The values, if they fit; of patches -1 is no hit, and all ones are no patch."""
    least, most = (-1, (1 << bits) - 2) if name == "patch" else (0, (1 << bits) - 1)
    if values.size and (values.min() < least or values.max() > most):
        raise InputError(f"results: {name} must be {least} to {most}, not {values.min()} to {values.max()}")
    return values


def unpack_hits(data: bytes, hit_format: HitFormat) -> FixedHits:
    """The hits in records of 16 or of 8 bytes.

    Raises
    ------
    InputError
        The format has no hits but their patches or nothing, or ``data`` is no whole number of records.
    """
    if hit_format not in (HitFormat.FULL, HitFormat.COMPACT):
        raise InputError(f"results: Hits are in records of 16 or of 8 bytes, not in format {hit_format!r}")
    if len(data) % hit_format.bytes:
        raise InputError(f"results: Bytes must be a multiple of {hit_format.bytes}, not {len(data)}")
    if hit_format == HitFormat.FULL:
        records = np.frombuffer(data, dtype=FULL_HIT.dtype)
        return FixedHits(**{name: records[name].astype(np.int64) for name in ("inverse", "patch", "u", "v")})
    words = np.frombuffer(data, dtype="<u8")
    fields = {name: (words >> np.uint64(first) & np.uint64((1 << bits) - 1)).astype(np.int64)
              for name, (bits, first) in _COMPACT.items()}
    none = fields["patch"] == (1 << _COMPACT["patch"][0]) - 1
    return FixedHits(**{**fields, "patch": np.where(none, -1, fields["patch"])})


def unpack_ids(data: bytes) -> np.ndarray:
    """The patches in records of 4 bytes: R int64, -1 for no hit.

    Raises
    ------
    InputError
        ``data`` is no whole number of records.
    """
    if len(data) % HitFormat.IDS.bytes:
        raise InputError(f"results: Bytes must be a multiple of {HitFormat.IDS.bytes}, not {len(data)}")
    ids = np.frombuffer(data, dtype="<u4").astype(np.int64)
    return np.where(ids == NO_PATCH, -1, ids)


def bit_words(rays: int) -> int:
    """Words of 8 bytes that have the bits of a list of so many rays; also without a ray there is one."""
    return max(1, -(-rays // 64))


def pack_bits(blocked: np.ndarray) -> bytes:
    """The words of the bits of a list's rays, from the lowest bit of the first word on; 0 behind the last ray."""
    return np.packbits(blocked, bitorder="little").tobytes().ljust(8 * bit_words(len(blocked)), b"\0")


def unpack_bits(data: bytes, rays: int) -> np.ndarray:
    """The bits of so many rays: bool."""
    return np.unpackbits(np.frombuffer(data, dtype=np.uint8), count=rays, bitorder="little").astype(bool)


def pack_sums(patch: np.ndarray, sums: np.ndarray) -> np.ndarray:
    """The words of sums: K uint64, little-endian.

    Raises
    ------
    InputError
        A sum or a patch has more bits than its field.
    """
    for name, values, bits in ("sums", sums, SUM_BITS), ("patches", patch, _SUM_PATCH_BITS):
        if len(values) and (values.min() < 0 or int(values.max()) >> bits):
            raise InputError(f"results: {name.capitalize()} must be 0 to {(1 << bits) - 1}, "
                             f"not {values.min()} to {values.max()}")
    return (sums.astype(np.uint64) | patch.astype(np.uint64) << np.uint64(PATCH_SHIFT)).astype("<u8")


def unpack_sums(words: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Patches and sums of words: K int64 each."""
    words = np.asarray(words, dtype=np.uint64)
    return ((words >> np.uint64(PATCH_SHIFT)).astype(np.int64),
            (words & np.uint64((1 << SUM_BITS) - 1)).astype(np.int64))


def scatter_sums(sections: Sequence[np.ndarray], patches: int) -> np.ndarray:
    """The sums of all patches of a frustum: those of its sections are added.

    Parameters
    ----------
    sections
        The words of each section.
    patches
        Number of patches N.

    Returns
    -------
    N int64.

    Raises
    ------
    InputError
        A word names a patch that does not exist.
    """
    sums = np.zeros(patches, dtype=np.int64)
    for words in sections:
        patch, value = unpack_sums(words)
        if len(patch) and patch.max() >= patches:
            raise InputError(f"results: Patches must be below {patches}, not {patch.max()}")
        np.add.at(sums, patch, value)
    return sums


@dataclass(frozen=True, kw_only=True)
class ResultCommand:
    """What is written of a section, and where.

    Parameters
    ----------
    hit_format
        The record of a hit.
    sums
        Sparse sums are written.
    hits, sums_address
        Addresses of the hit of ray (0, 0) of the frustum, and of the first word of sums.
    columns
        Columns of the frustum.
    section
        The rays.
    """

    hit_format: HitFormat
    sums: bool
    hits: int
    sums_address: int
    columns: int
    section: Sector


def section_rays(section: Sector, columns: int) -> np.ndarray:
    """Numbers of the section's rays in a frustum of ``columns`` columns, row by row: the order of read-out."""
    return (np.arange(section.first_row, section.end_row)[:, None] * columns
            + np.arange(section.first_column, section.end_column)).ravel()


def result_bytes(command: ResultCommand, hits: FixedHits, words: np.ndarray) -> dict[int, bytes]:
    """What memory holds after a section's results have been written: bytes by the address of the first of them.

    The width of a beat does not matter: bytes beside the results are not written.

    Parameters
    ----------
    command
        The command.
    hits
        The section's hits in the order of read-out.
    words
        The words of its sums (`pack_sums`); not written unless ``command.sums``.
    """
    section, size = command.section, command.hit_format.bytes
    columns = section.end_column - section.first_column
    extents = {}
    if size:
        records = pack_hits(hits, command.hit_format).reshape(section.end_row - section.first_row, columns * size)
        for row, data in enumerate(records, start=section.first_row):
            extents[command.hits + (row * command.columns + section.first_column) * size] = data.tobytes()
    if command.sums and len(words):
        extents[command.sums_address] = np.asarray(words, dtype="<u8").tobytes()
    return extents


def result_beats(command: ResultCommand, hits: FixedHits, words: np.ndarray, *,
                 data_bits: int) -> dict[int, tuple[int, int]]:
    """`result_bytes` in beats: data and strobes, a bit per byte, by the address of the beat.

    A writer may write a beat at once or in several parts. Strobes are those of all parts together; data without a
    strobe are 0.

    Parameters
    ----------
    command, hits, words
        As for `result_bytes`.
    data_bits
        Bits of a beat: 64, 128, 256 or 512.
    """
    size, beats = data_bits // 8, {}
    for address, data in result_bytes(command, hits, words).items():
        for beat in range(address // size, -(-(address + len(data)) // size)):
            begin, end = max(address, beat * size), min(address + len(data), (beat + 1) * size)
            value = int.from_bytes(data[begin - address:end - address], "little")
            shift, (before, strobe) = begin - beat * size, beats.get(beat * size, (0, 0))
            beats[beat * size] = (before | value << 8 * shift, strobe | (1 << end - begin) - 1 << shift)
    return beats
