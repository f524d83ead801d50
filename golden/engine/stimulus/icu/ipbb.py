"""Stimulus of `golden.engine.icu.ipbb`."""

from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.stimulus.frusta import random_screen
from golden.engine.stimulus.icu.window import window_block

__all__ = ["BLOCK"]

BLOCK = window_block("a patch, seen through one screen", ImagePlaneWindows, random_screen)
