"""Completion records: bytes at the offsets of the specification, and the lap that separates new ones from old ones."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.jobs.completion import COMPLETION, lap, parse_completions, patch_sources


def test_bytes_are_where_the_specification_says():
    offsets = {name: offset for name, (_, offset) in COMPLETION.dtype.fields.items()}
    assert offsets == {"address": 0, "sums": 8, "cycles": 12, "begin": 16, "end": 20, "tested": 24, "visited": 28,
                      "steps": 32, "found": 36, "own": 40, "remote": 44, "hits": 48, "misses": 52, "tag": 56,
                      "error": 60, "cluster": 61, "lap": 62}
    assert COMPLETION.dtype.itemsize == 64


def test_records_return_from_their_bytes():
    data = bytes(range(128))
    back = parse_completions(data)
    assert back.tobytes() == data
    assert back["lap"].tolist() == [0x3F3E, 0x7F7E]
    with pytest.raises(InputError, match="multiple of 64, not 127"):
        parse_completions(data[:-1])


@pytest.mark.parametrize(("number", "bits", "expected"), [
    (0, 2, 1), (3, 2, 1), (4, 2, 2), ((1 << 18) - 5, 2, 0xFFFF), ((1 << 18) - 4, 2, 0), (1 << 18, 2, 1), (5, 0, 6)])
def test_a_lap_counts_the_rings_and_is_not_zero_at_first(number, bits, expected):
    assert lap(number, bits) == expected


@pytest.mark.parametrize("bits", [0, 1, 3])
def test_an_entry_has_another_lap_until_its_completion_is_written(bits):
    ring = np.zeros(1 << bits, dtype=COMPLETION.dtype)
    # Twice around the laps' own modulus at the smallest ring would take long: begin shortly before it.
    for start in 0, (1 << 16 + bits) - 3 * len(ring):
        if start:
            ring["lap"] = lap(start - 1, bits)
        for number in range(start, start + 5 * len(ring)):
            assert ring["lap"][number % len(ring)] != lap(number, bits)
            ring["lap"][number % len(ring)] = lap(number, bits)


def test_what_no_other_source_has_served_is_from_the_patch_store():
    records = np.zeros(2, dtype=COMPLETION.dtype)
    for name, counts in {"found": (30, (1 << 32) - 1), "own": (9, 0), "remote": (8, 1), "hits": (5, 0),
                         "misses": (1, 0)}.items():
        records[name] = counts
    assert {name: counts.tolist() for name, counts in patch_sources(records).items()} == {
        "own": [9, 0], "kept": [7, (1 << 32) - 2], "remote": [8, 1], "hits": [5, 0], "misses": [1, 0]}
