"""Nodes: how many a machine may have, and how what they count is spread over them."""

import numpy as np

from golden.base.errors import InputError

__all__ = ["MOST_NODES", "check_power_of_two", "spread_over_nodes"]

MOST_NODES = 1024


def check_power_of_two(subject: str, name: str, value: int, most: int = MOST_NODES) -> None:
    """``value`` is a power of two up to ``most``.

    Raises
    ------
    InputError
        It is not; the message begins with the machine, the ``subject``, and the ``name``.
    """
    if not 1 <= value <= most or value & (value - 1):
        raise InputError(f"{subject}: {name} must be a power of two up to {most}, not {value!r}", parameter=name)


def spread_over_nodes(**counts: np.ndarray) -> dict[str, dict]:
    """The least, mean and most of what nodes count, by name, ready for JSON."""
    return {name: {"least": int(each.min()), "mean": float(each.mean()), "most": int(each.max())}
            for name, each in counts.items()}
