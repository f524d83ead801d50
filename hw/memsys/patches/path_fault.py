"""Faults of the memory system, from cells to vertices."""

from amaranth.lib import enum

__all__ = ["PathFault"]


class PathFault(enum.Enum, shape=3):
    """Why a cell or a patch has been dropped.

    ``CELL``: the scene has no such cell. ``LIST``: a cell's list is not within the patch lists. ``PATCH``: a list names
    a patch that the scene has not. ``RESIDENCE``: the residence table names a cluster that does not exist, or one that
    does not hold the patch. ``BUS``: it could not be read from main memory, or is malformed there. ``TIMEOUT``: a reply
    has been outstanding for too long.
    """

    NONE = 0
    CELL = 1
    LIST = 2
    PATCH = 3
    RESIDENCE = 4
    BUS = 5
    TIMEOUT = 6
