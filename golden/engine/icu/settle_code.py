"""Settle codes: a conservative floor of a ray's best inverse distance in a few bits."""

import numpy as np

from golden.engine.config import Config

__all__ = ["scale", "settle_code", "settle_floor", "settle_threshold"]

# Codes begin at 1/t = 2^FIRST_EXPONENT: a hit within the G cube is at most sqrt(3) away.
FIRST_EXPONENT = -1


def scale(config: Config) -> tuple[int, int]:
    """The stored inverse distance at which code 0 begins, and the fraction bits that a code omits."""
    numbers = config.numbers
    return (FIRST_EXPONENT + numbers.inverse_bias) << numbers.fraction_bits, \
        numbers.fraction_bits - config.icu.settle_fraction


def settle_code(inverse: np.ndarray, config: Config) -> np.ndarray:
    """The largest code whose floor is at most ``inverse`` (stored); 0 bounds nothing."""
    first, lost = scale(config)
    return np.clip((inverse - first) >> lost, 0, config.icu.settle.high)


def settle_floor(code: np.ndarray, config: Config) -> np.ndarray:
    """Least stored inverse distance of a ray with this code."""
    first, lost = scale(config)
    return np.where(code > 0, first + (code << lost), 0)


def settle_threshold(inverse: np.ndarray, config: Config) -> np.ndarray:
    """The smallest code whose floor is greater than ``inverse``; one more than the largest code if there is none.

    A patch with the bound ``inverse`` may still improve a ray whose code is below it.
    """
    first, lost = scale(config)
    return np.clip(((inverse - first) >> lost) + 1, 1, config.icu.settle.high + 1)
