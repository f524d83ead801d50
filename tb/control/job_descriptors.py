"""Descriptors at random, as words, and a memory that holds them."""

import random

import numpy as np

from golden.engine.config import Config
from golden.engine.jobs.descriptor import ANY_CLUSTER, DESCRIPTOR, NEAR_ALIGNMENT, VERSION, Kind

__all__ = ["WIDTHS", "byte_at", "changed", "descriptor", "near_words", "words_of"]

WIDTHS = (64, 128, 256, 512)


def byte_at(address: int) -> int:
    """The byte at an address of memory that nobody has written."""
    return (address * 37 ^ address >> 3) & 0xFF


def descriptor(config: Config, draw: random.Random, **fields: int) -> np.void:
    """A descriptor that is executed, with numbers at random and the given fields."""
    one = np.frombuffer(draw.randbytes(DESCRIPTOR.dtype.itemsize), dtype=DESCRIPTOR.dtype).copy()
    side = 1 << config.icu.side_bits
    columns, rows = draw.randint(1, min(side, 4)), draw.randint(1, min(side, 4))
    known = {"version": VERSION, "kind": Kind.FRUSTUM, "hit_format": draw.randrange(4), "sums": draw.randrange(2),
             "context": 0, "cluster": ANY_CLUSTER, "hits": 64 * draw.randrange(1000),
             "sums_address": 64 * draw.randrange(1000), "first_column": 0, "end_column": columns, "first_row": 0,
             "end_row": rows, "near_cells": 8 * draw.randrange(4000), "near_count": draw.randrange(7),
             "last_shell": draw.randrange(1, 1 << config.ctu.shell_bits), "ray_count": 0, "reserved": 0,
             "bundle": draw.randrange(2), "columns": columns, "rows": rows}
    return changed(one[0], **{**known, **fields})


def changed(one: np.void, **fields: int) -> np.void:
    """The descriptor with other fields."""
    found = np.array(one)[()].copy()
    for name, value in fields.items():
        found[name] = value
    return found


def words_of(one: np.void) -> list[int]:
    """Its words of 64 bits."""
    return np.frombuffer(one.tobytes(), dtype="<u8").tolist()


def near_words(one: np.void, config: Config) -> int:
    """How many words of near cells and of listed rays are read."""
    count, address = int(one["near_count"]), int(one["near_cells"])
    good = (one["kind"] == Kind.FRUSTUM and count <= 1 << config.ctu.near_cell_bits and address % NEAR_ALIGNMENT == 0
            and address < 1 << config.memory.address_bits and one["ray_count"] <= config.icu.listed_rays)
    return -(-count // 2) + int(one["ray_count"]) if good else 0
