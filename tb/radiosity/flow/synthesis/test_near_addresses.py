"""Spare address bits of distributed memories: what is read is the same."""

import random

import pytest

from radiosity.flow.synthesis.near_addresses import copy_addresses

WORDS, BITS, WIDTH = 16, 4, 4


def memory(read, write, seed):
    values = random.Random(seed).choices("01", k=WORDS * WIDTH)
    return {"cells": {"memory": {"type": "TRELLIS_DPR16X4", "parameters": {"INITVAL": "".join(values)},
                                 "connections": {"RAD": read, "WAD": write}}}}


def run(module, seed, cycles=200):
    """What is read in each cycle, of random words at random addresses."""
    cell, rng = module["cells"]["memory"], random.Random(seed)
    text = cell["parameters"]["INITVAL"]
    words = [text[WIDTH * (WORDS - 1 - address):][:WIDTH] for address in range(WORDS)]
    for _ in range(cycles):
        bits = {"0": 0, "1": 1} | {bit: rng.randrange(2) for bit in range(2 * BITS)}
        read, write = (sum(bits[bit] << k for k, bit in enumerate(cell["connections"][pin])) for pin in ("RAD", "WAD"))
        yield words[read]
        if rng.randrange(2):
            words[write] = f"{rng.randrange(WORDS):04b}"


@pytest.mark.parametrize(("read", "write", "gone"), [
    ([0, 1, 2, "0"], [4, 5, 6, "0"], 2), ([0, 1, "0", "0"], [4, 5, "0", "0"], 4),
    ([0, "0", "0", "0"], [4] + 3 * ["0"], 6),
    ([0, "0", 2, 3], [4, "0", 6, 7], 2), ([0, 1, 2, 3], [4, 5, 6, 7], 0), (4 * ["0"], 4 * ["0"], 0),
    # Read where it is not written: that bit is no spare one.
    ([0, 1, 2, "0"], [4, 5, 6, 7], 0), ([0, 1, 2, "1"], [4, 5, 6, "1"], 0)])
def test_what_is_read_is_the_same(read, write, gone):
    for seed in range(5):
        module = memory(list(read), list(write), seed)
        assert copy_addresses(module) == gone
        assert list(run(module, seed)) == list(run(memory(read, write, seed), seed))


def test_unmoved_initial_values_are_detected():
    module = memory([0, 1, 2, "0"], [4, 5, 6, "0"], 1)
    before = module["cells"]["memory"]["parameters"]["INITVAL"]
    copy_addresses(module)
    module["cells"]["memory"]["parameters"]["INITVAL"] = before
    assert list(run(module, 1)) != list(run(memory([0, 1, 2, "0"], [4, 5, 6, "0"], 1), 1))
