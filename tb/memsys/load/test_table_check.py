"""Pointers and sizes: the last record, or what the machine has bits for, passes, and one more does not."""

import random

import numpy as np
import pytest
from amaranth.hdl import Module, Mux
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from golden.engine.config import PRESETS
from golden.engine.memory_map import GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS, REGIONS, WEIGHT_BITS
from golden.engine.memory_map.rules import RULES, RuleKind
from hw.memsys.load.image_layout import PATCH_WORDS, RegionNumber
from hw.memsys.load.table_check import TableCheck
from hw.memsys.port.fault import Fault
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
SHAPE, SIDE, RAYS = 1 << GRID_SHAPE_BITS, 1 << GRID_SIDE_BITS, 1 << GRID_RAY_BITS


# A pointer, or a first record and a number of records, and the table that it points into.
POINTERS, RANGES = ([(rule.region, *rule.fields, rule.table) for rule in RULES if rule.kind in kinds] for kinds in (
    (RuleKind.BELOW, RuleKind.MAYBE), (RuleKind.RANGE,)))
NONE = (1 << 32) - 1


class Limited(wiring.Component):
    """A `TableCheck` where one region has ``count`` records, and the others as many as can be."""

    def __init__(self):
        self.check = TableCheck(config=CONFIG, tag=1)
        members = self.check.signature.members
        super().__init__({"i": members["i"], "o": members["o"], "region": In(RegionNumber), "count": In(32)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.check = check = self.check
        wiring.connect(m, wiring.flipped(self.i), check.i)
        wiring.connect(m, check.o, wiring.flipped(self.o))
        m.d.comb += check.limit.eq(Mux(check.table == self.region, self.count, NONE))
        return m


BENCH = ScheduleBench(Limited(), watchdog=10_000)


def faults(region, records, tables=None, *, stalls=0.0):
    """Of each word; a table that the records point into has so many records, the others as many as can be.

    In the share ``stalls`` of the words there is a gap, and in as many the output waits.
    """
    draw, ((name, count),) = random.Random(len(records)), (tables or {"cells": NONE}).items()
    words = [{"region": RegionNumber[region].value, "record": number, "word": word, "data": low | high << 32}
             for number, record in enumerate(records)
             for word, (low, high) in enumerate(zip(record[::2], record[1::2], strict=True))]
    idle, waits = ([draw.randrange(1, 4) * (draw.random() < stalls) for _ in words] for _ in range(2))
    items = [(gap, {"item": word, "tag": 1}) for gap, word in zip(idle, words, strict=True)]
    came = BENCH.run(Schedule(items={"i": items}, stalls={"o": waits}), region=RegionNumber[name.upper()].value,
                     count=count)["o"]
    assert [(one["item"], one["tag"]) for one in came] == [(word, 1) for word in words]
    if not stalls:
        assert BENCH.cycles["o"][0] - BENCH.cycles["i"][0] == documented_latency(TableCheck, CONFIG)
    found, size = [Fault(one["fault"]) for one in came], len(words) // len(records)
    return [found[size * k:size * (k + 1)] for k in range(len(records))]


def shell(rows, columns, first_ray):
    """Halves of a record of ``shells``, whose neighbours are large."""
    return [5, 7, 1 << 31, 1 << 31, 0, rows, 0, columns, first_ray, 0]


@pytest.mark.parametrize("stalls", [0.0, 0.5])
def test_grid_rays_of_shells(stalls):
    """Words of a record may come apart from each other and stall."""
    sizes = {(SIDE - 1, 1, 0): True, (SIDE, 1, 0): False, (1, SIDE - 1, 0): True, (1, SIDE, 0): False,
             (1 << 31, 0, 0): False, (0, 1 << 31, 0): False, (1024, RAYS >> 10, 0): True,
             (1024, RAYS >> 10, 1): False, (1023, RAYS >> 10, 1024): True, (1023, RAYS >> 10, 1025): False,
             (0, 0, RAYS): True, (0, 0, RAYS + 1): False, (1, 1, (1 << 32) - 1): False, (3, 5, 0): True}
    for size, found in zip(sizes, faults("SHELLS", [shell(*size) for size in sizes], stalls=stalls), strict=True):
        assert found == [Fault.NONE] * 4 + [Fault.NONE if sizes[size] else Fault.SIZE], size


@pytest.mark.parametrize("axis", range(3))
def test_cells_along_an_axis(axis):
    for value, fault in (SHAPE - 1, Fault.NONE), (SHAPE, Fault.SIZE), (1 << 31, Fault.SIZE):
        shape = [1, 1, 1]
        shape[axis] = value
        (found,) = faults("CELL_GRID", [[1 << 31] * 4 + [*shape, 0]])
        expected = [Fault.NONE] * 4
        expected[2 + axis // 2] = fault
        assert found == expected, (axis, value)


def test_weights_of_rays():
    for weight, fault in ((1 << WEIGHT_BITS) - 1, Fault.NONE), (1 << WEIGHT_BITS, Fault.SIZE), (1 << 63, Fault.SIZE):
        (found,) = faults("ROWS", [[NONE, NONE, weight & NONE, weight >> 32, NONE, 0]])
        assert found == [Fault.NONE, fault, Fault.NONE], weight


@pytest.mark.parametrize("kind", [0, 1, 128, 255])
def test_kinds_of_patches(kind):
    """All other bytes of the record are not 0, but the id is small."""
    (layout,) = (one for one in REGIONS if one.name == "patches")
    record = np.frombuffer(b"\xff" * layout.dtype.itemsize, dtype=layout.dtype).copy()
    record["id"], record["kind"] = 5, kind
    (found,) = faults("PATCHES", [np.frombuffer(record.tobytes(), dtype="<u4")[:2 * PATCH_WORDS].tolist()])
    assert found == [Fault.NONE, Fault.SIZE if kind else Fault.NONE, *[Fault.NONE] * (PATCH_WORDS - 2)]


def check_limits(region, cases):
    """Each case: fields of a record, the others 0; records of the tables that it points into; whether it may pass."""
    (layout,) = (one for one in REGIONS if one.name == region)
    for tables in {tuple(tables.items()) for _, tables, _ in cases}:
        some = [(values, passes) for values, given, passes in cases if tuple(given.items()) == tables]
        records = np.zeros(len(some), dtype=layout.dtype)
        for record, (values, _) in zip(records, some, strict=True):
            for name, value in values.items():
                record[name] = np.array(value, dtype="<u4").view(record[name].dtype)
        words = [np.frombuffer(one.tobytes() + bytes(-one.nbytes % 8), dtype="<u4").tolist() for one in records]
        for found, (values, passes) in zip(faults(region.upper(), words, dict(tables)), some, strict=True):
            assert {*found, Fault.NONE} == ({Fault.NONE} if passes else {Fault.NONE, Fault.POINTER}), (values, tables)


@pytest.mark.parametrize(("region", "field", "table"), POINTERS)
def test_pointers(region, field, table):
    check_limits(region, [
        ({field: value}, {table: count}, value < count or (region == "residence" and value >= NONE - 1))
        for count in (1, 7, NONE) for value in {0, count - 1, count, (count + 1) & NONE, NONE - 2, NONE - 1, NONE}])


@pytest.mark.parametrize(("region", "first", "count", "table"), RANGES)
def test_ranges(region, first, count, table):
    """Sums of two numbers that have 32 bits each do not wrap."""
    numbers = [(0, 0, 0), (0, 1, 0), (3, 4, 7), (3, 5, 7), (3, 3, 7), (7, 0, 7), (8, 0, 7), (0, 7, 7), (0, 8, 7),
               (NONE, 1, NONE), (NONE, 0, NONE)]
    # Shells have few rows and columns.
    numbers += [(1 << 31, 1 << 31, NONE), (NONE, NONE, NONE)] if region != "shells" else []
    check_limits(region, [({first: begin, count: length}, {table: records}, begin + length <= records)
                          for begin, length, records in numbers])
