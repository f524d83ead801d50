"""What can go wrong on the way from cells to vertices."""

from amaranth.lib import enum

__all__ = ["PathFault"]


class PathFault(enum.Enum, shape=3):
    """Why a cell or a patch has given nothing.

    ``CELL``: the scene has no such cell. ``LIST``: a cell's list is not within the patch lists. ``PATCH``: a list names
    a patch that the scene has not. ``RESIDENCE``: a patch is said to be with a cluster that there is not, or is asked
    of one that has not got it. ``BUS``: it could not be read from main memory, or what is there is malformed.
    ``TIMEOUT``: something has been waited for for too long.
    """

    NONE = 0
    CELL = 1
    LIST = 2
    PATCH = 3
    RESIDENCE = 4
    BUS = 5
    TIMEOUT = 6
