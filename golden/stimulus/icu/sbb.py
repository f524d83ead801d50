"""Stimulus of `golden.icu.sbb`."""

from golden.icu.sbb import SphericalWindows
from golden.stimulus.frusta import random_hemisphere
from golden.stimulus.icu.window import window_block

__all__ = ["BLOCK"]

BLOCK = window_block("a patch, seen through one hemisphere", SphericalWindows, random_hemisphere)
