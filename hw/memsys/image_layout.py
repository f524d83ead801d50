"""The layout of a memory image, `golden.memory_map`, as constants of the hardware."""

from dataclasses import dataclass

from amaranth.lib import enum

from golden.memory_map import REGIONS

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
    """What must hold of the numbers of a record.

    ``BELOW``: a < records of the table. ``MAYBE``: so, or -1 for none, or -2 for all. ``RANGE``: a + b <= records.
    ``SMALL``: a, b < 2^`GRID_SHAPE_BITS`. ``GRID``: of a shell, rows and columns < 2^`GRID_SIDE_BITS` and first_ray +
    rows columns <= 2^`GRID_RAY_BITS`. ``WEIGHT``: the word < 2^`WEIGHT_BITS`. ``QUAD``: the byte `KIND_BYTE` of the
    word is 0.
    """

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
    names = [region.name for region in REGIONS]
    for region, kind, table, a, b in (
            ("cells", RuleKind.RANGE, "patch_lists", "pointer", "count"),
            ("patch_lists", RuleKind.BELOW, "patches", "patch", None),
            ("patches", RuleKind.BELOW, "patches", "id", None),
            ("residence", RuleKind.MAYBE, "clusters", "cluster", None),
            ("clusters", RuleKind.RANGE, "subshells", "first_subshell", "subshells"),
            ("clusters", RuleKind.RANGE, "residents", "first_resident", "residents"),
            ("subshells", RuleKind.BELOW, "patches", "patch", None),
            ("residents", RuleKind.BELOW, "patches", "patch", None),
            ("shells", RuleKind.RANGE, "grid_rows", "first_row", "rows"),
            ("shells", RuleKind.RANGE, "grid_columns", "first_column", "columns")):
        fields = REGIONS[names.index(region)].dtype.fields
        first = fields[a][1]
        last = fields[b or a][1]
        early = first % WORD_BYTES != 0
        if b and last - first != WORD_BYTES // 2:
            raise ValueError(f"Fields of a rule must be neighbours, not {region}.{a} and {region}.{b}")
        # A high half alone is checked with the next word.
        word = last // WORD_BYTES + (early and not b)
        yield Rule(names.index(region), word, kind, names.index(table), early)
    for region, field, kind in (("cell_grid", "shape", RuleKind.SMALL), ("shells", "first_ray", RuleKind.GRID),
                                ("rows", "weight", RuleKind.WEIGHT)):
        for word in dict.fromkeys(word for word, _ in halves(region, field)):
            yield Rule(names.index(region), word, kind, names.index(region), early=False)
    patches = names.index("patches")
    yield Rule(patches, _KIND // WORD_BYTES, RuleKind.QUAD, patches, early=False)


RULES = tuple(_rules())
