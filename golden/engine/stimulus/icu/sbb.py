"""Stimulus of `golden.engine.icu.sbb`."""

from golden.engine.icu.sbb import SphericalWindows
from golden.engine.stimulus.frusta import random_hemisphere
from golden.engine.stimulus.icu.window import window_block

__all__ = ["BLOCK"]

BLOCK = window_block("a patch, seen through one hemisphere", SphericalWindows, random_hemisphere)
