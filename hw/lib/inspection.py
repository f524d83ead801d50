"""Components that are made to be looked at, and never elaborated."""

import gc
import traceback
import warnings
from collections.abc import Callable
from typing import TypeVar

from amaranth.hdl import UnusedElaboratable

__all__ = ["inspect"]

Result = TypeVar("Result")


def inspect(make: Callable, look: Callable[..., Result]) -> Result:
    """What ``look`` finds out about the component that ``make`` gives, without a warning that it is never elaborated.

    The result must not hold the component.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnusedElaboratable)
        try:
            return look(make())
        except Exception as error:
            # The frames of what has failed hold the component.
            traceback.clear_frames(error.__traceback__)
            raise
        finally:
            # Components are in cycles of references: the warning comes when they are collected.
            gc.collect()
