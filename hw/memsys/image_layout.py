"""Where things are in a memory image, for blocks that read one: `golden.memory_map` as constants of the hardware."""

from dataclasses import dataclass

from amaranth.lib import enum

from golden.memory_map import REGIONS

__all__ = ["HEADER_WORDS", "RECORD_BYTES", "RECORD_WORDS", "RULES", "RegionNumber", "Rule", "RuleKind"]

WORD_BYTES = 8
RegionNumber = enum.Enum("RegionNumber", {region.name.upper(): k for k, region in enumerate(REGIONS)})
# A region's records, and the words (or halves of words, see `RecordWords`) that one is sent in.
RECORD_BYTES = tuple(region.dtype.itemsize for region in REGIONS)
RECORD_WORDS = tuple(-(-size // WORD_BYTES) for size in RECORD_BYTES)
# Magic and version, size, and offset and count of each region.
HEADER_WORDS = 2 + 2 * len(REGIONS)


class RuleKind(enum.Enum, shape=3):
    """What must hold of the numbers of a record.

    ``BELOW``: a < records of the table. ``MAYBE``: so, or -1. ``RANGE``: a + b <= records. ``SPAN``: a < b <= records.
    ``SAME``: a = records.
    """

    NONE = 0
    BELOW = 1
    MAYBE = 2
    RANGE = 3
    SPAN = 4
    SAME = 5


@dataclass(frozen=True)
class Rule:
    """What must hold of one word of a record.

    Parameters
    ----------
    region, word
        Which word.
    kind
        See there.
    table
        The region that it points into.
    early
        a is the high half of the word before and b the low half; else a is the low half and b the high one.
    """

    region: int
    word: int
    kind: RuleKind
    table: int
    early: bool


def _rules():
    names = [region.name for region in REGIONS]
    for region, kind, table, a, b in (
            ("cells", RuleKind.RANGE, "patch_lists", "pointer", "count"),
            ("patch_lists", RuleKind.BELOW, "patches", "patch", None),
            ("patches", RuleKind.BELOW, "patches", "id", None),
            ("residence", RuleKind.MAYBE, "clusters", "cluster", None),
            ("clusters", RuleKind.SPAN, "columns", "first_column", "end_column"),
            ("clusters", RuleKind.SPAN, "rows", "first_row", "end_row"),
            ("clusters", RuleKind.RANGE, "subshells", "first_subshell", "subshells"),
            ("clusters", RuleKind.RANGE, "residents", "first_resident", "residents"),
            ("frustum", RuleKind.SAME, "columns", "columns", None),
            ("frustum", RuleKind.SAME, "rows", "rows", None),
            ("subshells", RuleKind.BELOW, "patches", "patch", None),
            ("residents", RuleKind.BELOW, "patches", "patch", None),
            ("near_cells", RuleKind.BELOW, "cells", "cell", None),
            ("shells", RuleKind.RANGE, "grid_rows", "first_row", "rows"),
            ("shells", RuleKind.RANGE, "grid_columns", "first_column", "columns")):
        fields = REGIONS[names.index(region)].dtype.fields
        first = fields[a][1]
        last = fields[b or a][1]
        early = first % WORD_BYTES != 0
        if b and last - first != WORD_BYTES // 2:
            raise ValueError(f"Fields of a rule must be neighbours, not {region}.{a} and {region}.{b}")
        # A high half alone is looked at with the next word.
        word = last // WORD_BYTES + (early and not b)
        yield Rule(names.index(region), word, kind, names.index(table), early)


RULES = tuple(_rules())
