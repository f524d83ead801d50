"""A list as it is in the table, then the last subshell; what cannot be right ends it with an error."""

import numpy as np
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.subshell_generator import ENTRIES, ListError, SubshellGenerator
from hw.ctu.subshell_table import SubshellTable
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.runner import SLOW_IN_ICARUS
from tb.lib.timing import documented_latency

CONFIG = config_of({"ctu.subshell_bits": 6})
TABLE, PATCHES, MOST_SHELLS = 64, (1 << CONFIG.icu.patch_bits) - 100, (1 << CONFIG.ctu.shell_bits) - 1
# Bits of a number in the table.
WORD = 32
LAST = {"patch": 0, "shell": 0, "last": 1}


class Listed(wiring.Component):
    """The generator with its table; what comes out says whether there has been an error."""

    def __init__(self, config):
        self._config = config
        self._generator, self._table = SubshellGenerator(config=config), SubshellTable(config=config)
        self.table_latency = self._table.latency
        assert self.table_latency == documented_latency(SubshellTable, config)
        out = StructLayout({"subshell": CtuFormats(config).subshell, "error": ListError})
        super().__init__({
            "i_load": In(self._table.i_load.signature.flip()), "i": In(self._generator.i.signature.flip()),
            "o": Out(stream.Signature(out))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.generator, m.submodules.table = generator, table = self._generator, self._table
        wiring.connect(m, wiring.flipped(self.i), generator.i)
        wiring.connect(m, wiring.flipped(self.i_load), table.i_load)
        wiring.connect(m, generator.o_read, table.i)
        wiring.connect(m, table.o, generator.i_read)
        m.d.comb += [self.o.valid.eq(generator.o.valid), generator.o.ready.eq(self.o.ready),
                     self.o.payload.subshell.eq(generator.o.payload), self.o.payload.error.eq(generator.error)]
        return m


def lists(seed):
    """A table, and lists in it: right ones, empty ones, all of the table, and every wrong one."""
    random = np.random.default_rng(seed)
    entries = [{"patch": int(random.integers(PATCHES)), "shell": int(random.integers(1, MOST_SHELLS + 20))}
               for _ in range(TABLE)]
    # Any one of the bits that say that a shell is beyond all.
    for entry in entries[::3]:
        entry["shell"] = 1 << int(random.integers(MOST_SHELLS.bit_length(), WORD))
    entries[20]["patch"] = PATCHES
    entries[30]["patch"] = 1 << int(random.integers(CONFIG.icu.patch_bits, WORD)) | 5
    entries[40]["shell"] = 0
    entries[50]["shell"] = 1 << 31
    # Wider than any number of a patch.
    for entry in entries[51:]:
        entry["patch"] = int(random.integers(1 << CONFIG.icu.patch_bits, 1 << random.integers(
            CONFIG.icu.patch_bits + 1, WORD)))
    whole = {"first": 0, "patches": PATCHES}
    return entries, [
        {**whole, "count": 20}, {**whole, "count": 0}, {**whole, "first": TABLE, "count": 0},
        {**whole, "first": 41, "count": TABLE - 41}, {**whole, "count": TABLE}, {**whole, "first": 15, "count": 9},
        {**whole, "first": 25, "count": 9}, {**whole, "first": 38, "count": 3}, {**whole, "first": 40, "count": 1},
        {**whole, "count": TABLE + 1}, {**whole, "first": 60, "count": 5}, {**whole, "first": TABLE + 1, "count": 0},
        {**whole, "first": 1 << 31, "count": 1 << 31}, {**whole, "first": 3, "count": (1 << 32) - 1},
        {**whole, "first": 1, "count": 12, "patches": 1 << 31}, *_at_limits(entries, random)]


def _at_limits(entries, random):
    """Lists of one patch that is the last one or one beyond, and lists just inside and outside the table."""
    for first, entry in enumerate(entries):
        is_last = entry["patch"] < 1 << CONFIG.icu.patch_bits and random.integers(2)
        yield {"first": first, "count": 1, "patches": entry["patch"] + int(is_last)}
    for bit in range(WORD):
        beyond = TABLE | 1 << bit if 1 << bit < TABLE else 1 << bit
        if beyond > TABLE:
            yield {"first": beyond, "count": 0, "patches": PATCHES}
            yield {"first": 0, "count": beyond, "patches": PATCHES}
    for first in random.integers(TABLE, size=8).tolist():
        for count in (TABLE - first, TABLE - first + 1):
            yield {"first": first, "count": count, "patches": PATCHES}


def expected(entries, given):
    """Subshells, and the error of the last one."""
    if given["first"] + given["count"] > TABLE:
        return [LAST], ListError.LENGTH
    made = []
    for entry in entries[given["first"]:given["first"] + given["count"]]:
        if entry["patch"] >= given["patches"]:
            return [*made, LAST], ListError.PATCH
        if not entry["shell"]:
            return [*made, LAST], ListError.SHELL
        made.append({"patch": entry["patch"], "shell": min(entry["shell"], MOST_SHELLS), "last": 0})
    return [*made, LAST], ListError.NONE


def loads(entries):
    """The table's writes."""
    return {"i_load": [{"address": address, **entry} for address, entry in enumerate(entries)]}


def vectors(entries, given):
    """What comes of lists."""
    produced = []
    for one in given:
        subshells, error = expected(entries, one)
        produced += [{"subshell": subshell, "error": error.value * (subshell is subshells[-1])}
                     for subshell in subshells]
    return Vectors(inputs={"i": given}, first=loads(entries), expected={"o": produced})


class TestSubshellGenerator(Bench):
    variants, splits = ({},), False
    simulators = SLOW_IN_ICARUS

    def make(self, config):
        return Listed(CONFIG)

    def latency(self, component, config):
        return documented_latency(SubshellGenerator, CONFIG) + component.table_latency

    def vectors(self, config):
        return vectors(*lists(1))

    def drawn(self, config, seed):
        entries, given = lists(seed)
        return vectors(entries, given[seed % 3::3])

    def predict(self, given, trace, component, config):
        """Entries pass a queue; the last subshell follows the last entry, or the first one that is wrong."""
        begins, subshells, free = [], [], 0
        for one, offered in zip(given.inputs["i"], trace.offered["i"], strict=True):
            produced, error = expected(given.first["i_load"], one)
            begins.append(max(offered, free))
            requested, left = [begins[-1] + 1], [0] * ENTRIES
            for number in range(0 if error == ListError.LENGTH else one["count"]):
                request = max(requested[-1], left[-ENTRIES]) + 1
                if number >= len(produced) and request > left[ENTRIES + len(produced) - 1]:
                    break
                requested.append(request)
                leaves = max(request + self.latency(component, config) - 2, left[-1] + 1)
                left.append(trace.ready("o", leaves) if number < len(produced) - 1 else leaves)
            free = trace.ready("o", left[-1] + 2 if len(left) > ENTRIES else begins[-1] + 3) + 1
            subshells += [*left[ENTRIES:][:len(produced) - 1], free - 1]
        return {"i": begins, "o": subshells}


def test_lists_hold_every_case():
    entries, given = lists(1)
    coverage = Coverage(["a list", "none", "of the whole table", *(f"error {error.name}" for error in ListError)])
    for one in given:
        subshells, error = expected(entries, one)
        coverage.hit_all({"a list": len(subshells) > 1, "none": not one["count"],
                          "of the whole table": one["count"] == TABLE, f"error {error.name}": True})
    coverage.check()
