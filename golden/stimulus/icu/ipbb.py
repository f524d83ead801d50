"""Stimulus of `golden.icu.ipbb`."""

from golden.icu.ipbb import ImagePlaneWindows
from golden.stimulus.frusta import random_screen
from golden.stimulus.icu.window import window_block

__all__ = ["BLOCK"]

BLOCK = window_block("a patch, seen through one screen", ImagePlaneWindows, random_screen)
