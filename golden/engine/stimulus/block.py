"""Blocks and fields of stimuli."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from golden.engine.config import Config
from golden.engine.lib.fixed import Format, unsigned

__all__ = ["FLAG", "Arrays", "Block", "Field", "hard_first", "padded"]

Arrays = dict[str, np.ndarray]
# Format of a value that is 0 or 1.
FLAG = unsigned(1, 0)


@dataclass(frozen=True)
class Field:
    """One input or output of a block.

    Parameters
    ----------
    name, about
        Name and meaning.
    format
        Format of its integers; None for float64.
    constant
        Whether it is one array for all vectors; else its first axis counts the vectors.
    """

    name: str
    format: Format | None
    about: str
    constant: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """Generator of a block's stimulus.

    Parameters
    ----------
    about
        Meaning of one vector.
    fields
        Inputs and outputs for a configuration.
    draw
        Function from a random generator, a number of vectors and a configuration to the inputs: the block's hard cases
        first.
    expect
        Function from the inputs and a configuration to the outputs.
    """

    about: str
    fields: Callable[[Config], tuple[list[Field], list[Field]]]
    draw: Callable[[np.random.Generator, int, Config], Arrays]
    expect: Callable[[Arrays, Config], Arrays]


def hard_first(drawn: np.ndarray, hard) -> np.ndarray:
    """``drawn`` with its first vectors, at most half of them, replaced by the hard cases."""
    hard = np.asarray(hard)[:(len(drawn) + 1) // 2]
    drawn[:len(hard)] = hard
    return drawn


def padded(lists: list[np.ndarray]) -> np.ndarray:
    """Lists as rows of one array, padded with -1."""
    rows = np.full((len(lists), max([1, *map(len, lists)])), -1, dtype=np.int64)
    for row, values in zip(rows, lists, strict=True):
        row[:len(values)] = values
    return rows
