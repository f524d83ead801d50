"""Values at the ends of what a shape can hold: drawn by Hypothesis, and as arrays for vectors."""

import numpy as np
from amaranth.hdl import Shape
from hypothesis import strategies as st

__all__ = ["ends", "integers", "numbers"]


def ends(shape) -> list[int]:
    """The least and the greatest value of a shape, those beside them, and 0 and those beside it."""
    low, high = _limits(shape)
    return sorted({value for value in (low, low + 1, -1, 0, 1, high - 1, high) if low <= value <= high})


def integers(shape) -> st.SearchStrategy[int]:
    """All values of a shape, a quarter of them `ends`; 0 is the simplest one."""
    each = st.integers(*_limits(shape))
    return st.one_of(each, each, each, st.sampled_from(sorted(ends(shape), key=abs)))


def numbers(generator: np.random.Generator, shape, count: int, *, least: int | None = None) -> np.ndarray:
    """The `ends` of a shape, its middle, and ``count`` values of all sizes.

    Parameters
    ----------
    least
        No value is less; default: the least one of the shape.
    """
    (low, high), cast = _limits(shape), Shape.cast(shape)
    sizes = generator.integers(0, cast.width - cast.signed + 1, count)
    values = generator.integers(0, 1 << 62, count) >> (62 - sizes)
    if cast.signed:
        values = np.where(generator.integers(0, 2, count), values, -values)
    return np.clip(np.concatenate([ends(shape), [high >> 1, (high >> 1) + 1], values]),
                   low if least is None else least, high)


def _limits(shape):
    cast = Shape.cast(shape)
    low = -(1 << cast.width - 1) if cast.signed else 0
    return low, low + (1 << cast.width) - 1
