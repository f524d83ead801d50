"""Kinds of bundles of rays."""

from enum import IntEnum

__all__ = ["Bundle"]


class Bundle(IntEnum):
    """What the rays of a frustum are; the number is that of a descriptor."""

    HEMISPHERE = 0
    SCREEN = 1
    SHADOW = 2
