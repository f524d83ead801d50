"""What a block's stimulus is made of."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from golden.config import Config
from golden.fixed import Format, unsigned

__all__ = ["FLAG", "Arrays", "Block", "Field", "hard_first", "padded"]

Arrays = dict[str, np.ndarray]
# Of what is 0 or 1.
FLAG = unsigned(1, 0)


@dataclass(frozen=True)
class Field:
    """One input or output.

    Parameters
    ----------
    name, about
        What it is called, and what it is.
    format
        Of each of its integers; None for float64 numbers.
    constant
        It is one array for all vectors. Otherwise its first axis counts the vectors.
    """

    name: str
    format: Format | None
    about: str
    constant: bool = False


@dataclass(frozen=True, kw_only=True)
class Block:
    """How the stimulus of a block is made.

    Parameters
    ----------
    about
        What one vector is.
    fields
        Inputs and outputs for a configuration.
    draw
        The inputs of a number of vectors, from a random generator: the block's hard cases, then others.
    expect
        The outputs, from nothing but the inputs.
    """

    about: str
    fields: Callable[[Config], tuple[list[Field], list[Field]]]
    draw: Callable[[np.random.Generator, int, Config], Arrays]
    expect: Callable[[Arrays, Config], Arrays]


def hard_first(drawn: np.ndarray, hard) -> np.ndarray:
    """``drawn`` with the hard cases in place of its first vectors, but at most of half of them."""
    hard = np.asarray(hard)[:(len(drawn) + 1) // 2]
    drawn[:len(hard)] = hard
    return drawn


def padded(lists: list[np.ndarray]) -> np.ndarray:
    """Lists as rows of one array, filled up with -1."""
    rows = np.full((len(lists), max([1, *map(len, lists)])), -1, dtype=np.int64)
    for row, values in zip(rows, lists, strict=True):
        row[:len(values)] = values
    return rows
