"""Regions of an image: as long as they may be, one record fewer, and one more; and several faults of a header."""

import random

import pytest

from golden.engine.config import PRESETS
from golden.engine.memory_map import MAGIC, REGIONS, VERSION
from hw.memsys.load.image_header import ImageHeader
from hw.memsys.load.image_layout import HEADER_WORDS, RECORD_BYTES
from hw.memsys.port.fault import Fault
from tb.lib.responder import Responder
from tb.lib.schedules import Schedule, ScheduleBench

CONFIG = PRESETS["tiny"]
MEMORY = 1 << CONFIG.memory.address_bits
BYTES = {region.name: size for region, size in zip(REGIONS, RECORD_BYTES, strict=True)}
BASE, SIZE = 1 << 20, 1 << 36
# Of the machine, see `Config`.
MOST = {
    "cells": CONFIG.memsys.scene_cells, "patches": 1 << CONFIG.icu.patch_bits,
    "columns": 1 << CONFIG.icu.side_bits, "rows": 1 << CONFIG.icu.side_bits, "shells": (1 << CONFIG.ctu.shell_bits) - 2,
    "grid_rows": 1 << CONFIG.ctu.grid_row_bits, "grid_columns": 1 << CONFIG.ctu.grid_column_bits}


@pytest.fixture(scope="module")
def bench():
    return ScheduleBench(ImageHeader(config=CONFIG), idle_limit=400, watchdog=10_000)


def fault(bench, *, base=BASE, size=SIZE, offsets=(), others=(), errors=(), **counts):
    """The fault of a header with regions of so many records, by default none of wrong length.

    Parameters
    ----------
    others
        By number words with another value.
    errors
        Numbers of the words that cannot be read.
    """
    counts = dict.fromkeys(BYTES, 0) | {"cell_grid": 1} | counts
    words = [MAGIC | VERSION << 32, size]
    for name, count in counts.items():
        words += [dict(offsets).get(name, 4096), count]
    read = Responder("o_extent", "i_word", lambda extent: [
        {"data": dict(others).get(number, word), "last": number == HEADER_WORDS - 1, "error": number in errors}
        for number, word in enumerate(words)])
    came = bench.run(Schedule(items={"i": [(0, base)]}), read)
    assert came["o_extent"] == [{"address": base, "length": HEADER_WORDS - 1, "narrow": 0}]
    (found,) = came["o"]
    return Fault(found)


@pytest.mark.parametrize("region", MOST)
def test_the_most_records(bench, region):
    for count in MOST[region] - 1, MOST[region], MOST[region] + 1:
        others = {"residence": count} if region == "patches" else {}
        expected = Fault.NONE if count <= MOST[region] else Fault.REGION
        assert fault(bench, **{region: count}, **others) is expected, count


@pytest.mark.parametrize(("counts", "passes"), [
    ({"patches": 9, "residence": 9}, True), ({"patches": 9, "residence": 8}, False),
    ({"patches": 9, "residence": 10}, False), ({"patches": 0, "residence": 1}, False), ({"cell_grid": 1}, True),
    ({"cell_grid": 0}, False), ({"cell_grid": 2}, False), ({"cell_grid": 1 << 31}, False)])
def test_regions_as_long_as_others(bench, counts, passes):
    assert fault(bench, **counts) is (Fault.NONE if passes else Fault.REGION)


@pytest.mark.parametrize("region", BYTES)
def test_regions_end_within_the_image(bench, region):
    """At a multiple of 64; the size of an image need not be a multiple of anything."""
    counts = {"patches": 1, "residence": 1, region: 1}
    size = BYTES[region] * counts[region]
    last, others = SIZE - -(-size // 64) * 64, dict.fromkeys(set(BYTES) - {region}, 0)
    for offset, image, passes in ((last, SIZE, True), (last + 64, SIZE, False), (4096 + 8, SIZE, False),
                                  (4096, 4096 + size, True), (4096, 4096 + size - 1, False)):
        expected = Fault.NONE if passes else Fault.REGION
        assert fault(bench, size=image, offsets=others | {region: offset}, **counts) is expected, (offset, image)


@pytest.mark.parametrize("region", ["patch_lists", "clusters", "subshells", "residents"])
def test_lengths_do_not_wrap(bench, region):
    """Of tables that the machine reads in parts: up to 2^32 records, in an image of any size."""
    largest = (1 << 32) - 1
    least = BYTES[region] * largest + 4096
    assert fault(bench, size=MEMORY - BASE, **{region: largest}) is (
        Fault.NONE if least <= MEMORY - BASE else Fault.REGION)
    assert fault(bench, size=4096 + BYTES[region], **{region: largest}) is Fault.REGION
    assert fault(bench, **{region: 1 << 32}) is Fault.REGION


@pytest.mark.parametrize(("base", "size", "passes"), [
    (BASE, MEMORY - BASE, True), (BASE, MEMORY - BASE + 1, False), (0, MEMORY, False), (0, MEMORY - 1, True),
    (MEMORY - 8192, 8192, True), (MEMORY - 8192, 8193, False), (BASE, 1 << 63, False), (BASE, 0, False)])
def test_images_end_within_memory(bench, base, size, passes):
    """An image that fills all of memory has a size of one bit too many."""
    assert fault(bench, base=base, size=size) is (Fault.NONE if passes else Fault.REGION)


def test_the_first_of_several_faults_counts(bench):
    """In the order of the words; what a word holds that cannot be read has no meaning."""
    draw = random.Random(3)
    for number in range(0, HEADER_WORDS, 5):
        garbage = {k: draw.getrandbits(64) for k in range(number, HEADER_WORDS)}
        assert fault(bench, others=garbage, errors={number}) is Fault.READ_REPLY, number
        if number:
            assert fault(bench, others=garbage | {0: MAGIC}, errors={number}) is Fault.IMAGE, number
    assert fault(bench, others={0: 1, 3: 1 << 40}) is Fault.IMAGE
    assert fault(bench, others={3: 1 << 40}, errors={4}) is Fault.REGION
