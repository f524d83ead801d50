"""The layout of a memory image, `golden.engine.memory_map`, as constants of the hardware."""

from dataclasses import dataclass

from amaranth.lib import enum

from golden.engine.memory_map import REGIONS, rules

__all__ = ["COUNT_BITS", "HEADER_WORDS", "KIND_BYTE", "PATCH_WORDS", "RECORD_BYTES", "RECORD_WORDS", "RULES",
           "WORD_BITS", "RegionNumber", "Rule", "RuleKind", "halves"]

WORD_BYTES = 8
WORD_BITS = 8 * WORD_BYTES
# Of a number of records, and of every index into a table.
COUNT_BITS = 32
RegionNumber = enum.Enum("RegionNumber", {region.name.upper(): k for k, region in enumerate(REGIONS)})
# By region: the bytes of a record, and the transfers that it takes: words, or one half word.
RECORD_BYTES = tuple(region.dtype.itemsize for region in REGIONS)
RECORD_WORDS = tuple(-(-size // WORD_BYTES) for size in RECORD_BYTES)
# Of a patch's record, those that are not padding.
PATCH_WORDS = 6
# Of its kind: the byte in the record, and in the word.
_KIND = REGIONS[RegionNumber.PATCHES.value].dtype.fields["kind"][1]
KIND_BYTE = _KIND % WORD_BYTES
# Magic and version, size, and offset and count of each region.
HEADER_WORDS = 2 + 2 * len(REGIONS)


def halves(region: str, field: str) -> list[tuple[int, bool]]:
    """Of each element of a 32-bit field: the word of the record, and whether it is the high half."""
    layout = next(one for one in REGIONS if one.name == region)
    count = next(one for one in layout.fields if one.name == field).count
    first = layout.dtype.fields[field][1]
    return [(byte // WORD_BYTES, byte % WORD_BYTES != 0) for byte in range(first, first + 4 * count, 4)]


class RuleKind(enum.Enum, shape=3):
    """Those of `golden.engine.memory_map.rules.RuleKind`, of the numbers a and b of a word; NONE: any."""

    NONE = 0
    BELOW = 1
    MAYBE = 2
    RANGE = 3
    SMALL = 4
    GRID = 5
    WEIGHT = 6
    QUAD = 7


@dataclass(frozen=True)
class Rule:
    """The rule of one word of a record.

    Parameters
    ----------
    region, word
        The word.
    kind
        The rule.
    table
        The region that the word points into.
    early
        a is the high half of the previous word and b the low half; otherwise a is the low half and b the high one.
    """

    region: int
    word: int
    kind: RuleKind
    table: int
    early: bool


def _rules():
    """A rule for each word of `golden.engine.memory_map.rules.RULES`."""
    for rule in rules.RULES:
        region, table, kind = (RegionNumber[rule.region.upper()].value, RegionNumber[rule.table.upper()].value,
                               RuleKind[rule.kind.name])
        fields = REGIONS[region].dtype.fields
        first, last = fields[rule.fields[0]][1], fields[rule.fields[-1]][1]
        if kind in (RuleKind.BELOW, RuleKind.MAYBE, RuleKind.RANGE):
            early = first % WORD_BYTES != 0
            if kind is RuleKind.RANGE and last - first != WORD_BYTES // 2:
                raise ValueError(f"Fields of a rule must be neighbours, not {rule.region}.{', '.join(rule.fields)}")
            # A high half alone is checked with the next word.
            yield Rule(region, last // WORD_BYTES + (early and kind is not RuleKind.RANGE), kind, table, early)
        elif kind is RuleKind.QUAD:
            yield Rule(region, first // WORD_BYTES, kind, table, early=False)
        else:
            for word in dict.fromkeys(word for word, _ in halves(rule.region, rule.fields[0])):
                yield Rule(region, word, kind, table, early=False)


RULES = tuple(_rules())
