"""Whole numbers of a range, its ends and the borders of its bits among them more often than by chance."""

from hypothesis import strategies as st

__all__ = ["at_ends"]


def at_ends(low: int, high: int):
    """A strategy of numbers from ``low`` to ``high``: both ends, powers of two and their neighbours, and all others."""
    powers = [1 << bit for bit in range(max(abs(low), abs(high)).bit_length())]
    special = {low, low + 1, -1, 0, 1, high - 1, high}
    special |= {sign * power + step for power in powers for sign in (1, -1) for step in (-1, 0, 1)}
    special = sorted((value for value in special if low <= value <= high), key=abs)
    return st.one_of(st.sampled_from(special), st.integers(low, high), st.sampled_from((low, high)))
