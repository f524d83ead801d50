"""Sections with their hits and sums, as items of the result writer, and the beats and requests that they become."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby
from random import Random

import numpy as np

from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import (
    HitFormat,
    ResultCommand,
    pack_hits,
    pack_sums,
    result_bytes,
    section_rays,
)
from tb.lib.stages import Trace

__all__ = ["FULL_GROUP", "Packing", "SectionResults", "drawn_section", "joined"]

# Beats of the longest request.
FULL_GROUP = 16


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionResults:
    """A section's command, its hits in the order of read-out, and its sums.

    Parameters
    ----------
    command, hits
        As for `golden.engine.jobs.result_formats.result_bytes`.
    patches, sums
        Of the words of sums, in their order.
    """

    command: ResultCommand
    hits: FixedHits
    patches: list[int]
    sums: list[int]

    @property
    def command_item(self) -> dict:
        """`ResultFormats.section_command`."""
        given = vars(self.command)
        return {**given, "hit_format": int(self.command.hit_format), "sums": int(self.command.sums),
                "section": vars(self.command.section)}

    @property
    def hit_items(self) -> list[dict]:
        """`ResultFormats.hit`."""
        rays = section_rays(self.command.section, self.command.columns).tolist()
        fields = {name: getattr(self.hits, name).tolist() for name in ("inverse", "patch", "u", "v")}
        items = []
        for number, ray in enumerate(rays):
            hit = {name: values[number] for name, values in fields.items()}
            items.append({"column": ray % self.command.columns, "row": ray // self.command.columns,
                          "hit": hit if hit["inverse"] else dict.fromkeys(hit, 0), "last": number == len(rays) - 1})
        return items

    @property
    def sum_items(self) -> list[dict]:
        """`IcuFormats.section_sum`; without sums an item that has no meaning but ``last``."""
        items = [{"patch": patch, "sum": value, "is_sum": 1, "last": number == len(self.sums) - 1}
                 for number, (patch, value) in enumerate(zip(self.patches, self.sums, strict=True))]
        return items or [{"patch": 5, "sum": 77, "overflow": len(self.hits.patch) & 1, "is_sum": 0, "last": 1}]

    @property
    def words(self) -> np.ndarray:
        """The words of sums."""
        return pack_sums(np.array(self.patches, dtype=np.int64), np.array(self.sums, dtype=np.int64))

    @property
    def memory(self) -> dict[int, int]:
        """Each byte that is written."""
        return {address + k: byte for address, data in result_bytes(self.command, self.hits, self.words).items()
                for k, byte in enumerate(data)}

    def beats(self, data_bits: int) -> list[dict]:
        """`ResultFormats.beat`, one after the other; what lies in lanes that are not written is 0."""
        command, size, records = self.command, data_bits // 8, []
        if command.hit_format.bytes:
            rays = section_rays(command.section, command.columns).tolist()
            records.append([(command.hits + ray * command.hit_format.bytes, bytes(record)) for ray, record in zip(
                rays, pack_hits(self.hits, command.hit_format), strict=True)])
        if command.sums and self.sums:
            records.append([(command.sums_address + 8 * k, word.tobytes()) for k, word in enumerate(self.words)])
        found = []
        for part in records:
            single = [(address + k, byte) for address, record in part for k, byte in enumerate(record)]
            beats = [(number, list(those)) for number, those in groupby(single, key=lambda one: one[0] // size)]
            for (number, those), following in zip(beats, [*(number for number, _ in beats[1:]), None], strict=True):
                found.append({
                    "number": number, "data": sum(byte << 8 * (address % size) for address, byte in those),
                    "lanes": sum(1 << address % size // 4 for address, _ in those if address % 4 == 0),
                    "ends": following != number + 1 or following % FULL_GROUP == 0})
        return found

    def requests(self, data_bits: int) -> list[dict]:
        """Address and length of each request."""
        return [{"address": those[0]["number"] * (data_bits // 8), "length": len(those) - 1}
                for those in requests_of(self.beats(data_bits))]


def requests_of(beats: list[dict]) -> list[list[dict]]:
    """The beats of each request."""
    parts, part = [], []
    for beat in beats:
        part.append(beat)
        if beat["ends"]:
            parts.append(part)
            part = []
    assert not part
    return parts


class Packing:
    """When hits and sums are accepted, as the docstring of `hw.memsys.results.result_packer.ResultPacker` says.

    Parameters
    ----------
    data_bits
        Of a beat.
    trace
        When hits and sums are offered.
    found
        By stream the cycles in which they are accepted.
    leave
        From the first cycle of a beat's offer, and the beat, to the cycle in which it is accepted.
    """

    def __init__(self, data_bits: int, trace: Trace, found: dict[str, list[int]],
                 leave: Callable[[int, dict], int]):
        self._bits, self._found, self._leave, self._left = data_bits, found, leave, 0
        self._offered = {name: iter(trace.offered[name]) for name in ("i_hit", "i_sum")}

    def add(self, one: SectionResults, now: int) -> int:
        """A section that begins in a cycle; gives the cycle of its last sum."""
        beats, missing, lanes = iter(one.beats(self._bits)), 0, self._bits // 32
        size = one.command.hit_format.bytes // 4
        hit, total = [min(size, lanes)] * max(1, size // lanes), [2 * (one.command.sums and bool(one.sums))]
        for name, parts in [("i_hit", hit)] * len(one.hit_items) + [("i_sum", total)] * len(one.sum_items):
            now = max(now, next(self._offered[name]) - 1)
            for part in parts:
                # While a beat is full nothing is accepted; it is offered a cycle after its last lanes.
                now = max(now + 1, self._left)
                if part and not missing:
                    beat = next(beats)
                    missing = beat["lanes"].bit_count()
                missing -= part
                if part and not missing:
                    self._left = self._leave(now + 1, beat)
            self._found[name].append(now)
        return now


def drawn_section(seed: int, config: Config, *, base: int = 0, side: int = 12, **given) -> SectionResults:
    """A random section, a third of its rays without a hit.

    Parameters
    ----------
    base
        All addresses are from there on.
    side
        Columns of the frustum at most.
    given
        Fields of the command.
    """
    random = Random(seed)
    hit_format = given.pop("hit_format", None)
    hit_format = HitFormat(random.randrange(4)) if hit_format is None else hit_format
    columns = given.pop("columns", None) or random.randint(1, side)
    first, end = sorted(random.sample(range(columns + 1), 2)) if random.random() < 0.7 else (0, columns)
    row = random.randrange(5)
    section = given.pop("section", None) or Sector(first, end, row, row + random.randint(1, 4))
    unit = max(8, hit_format.bytes)
    command = ResultCommand(**{
        "hit_format": hit_format, "sums": random.random() < 0.7, "hits": base + random.randrange(64) * unit,
        "sums_address": base + 8 * random.randrange(10_000, 10_100), "columns": columns, "section": section, **given})
    draw, rays = np.random.default_rng(seed), len(section_rays(section, columns))
    patch = np.where(draw.random(rays) < 0.3, -1, draw.integers(0, 1 << config.icu.patch_bits, rays))
    highest = {"inverse": 1 << config.numbers.inverse.width, "u": 1 << config.icu.uv_bits, "v": 1 << config.icu.uv_bits}
    given = {name: draw.integers(1, high, rays) for name, high in highest.items()}
    # Any bit alone makes a hit of an inverse distance.
    single = 1 << draw.integers(0, config.numbers.inverse.width, rays)
    given["inverse"] = np.where(draw.random(rays) < 0.2, single, given["inverse"])
    hits = FixedHits(patch=patch, **{name: np.where(patch >= 0, values, 0) for name, values in given.items()})
    count = random.randint(0, 9)
    patches = random.sample(range(1 << config.icu.patch_bits), count)
    return SectionResults(command=command, hits=hits, patches=patches,
                          sums=[random.randrange(1, 1 << 42) for _ in patches])


def joined(sections: list[SectionResults]) -> dict[str, list]:
    """The items of several sections, one after the other."""
    return {"i": [one.command_item for one in sections], "i_hit": [item for one in sections for item in one.hit_items],
            "i_sum": [item for one in sections for item in one.sum_items]}
