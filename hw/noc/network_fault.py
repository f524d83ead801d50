"""Faults of flits."""

from amaranth.lib import enum

__all__ = ["NetworkFault"]


class NetworkFault(enum.Enum, shape=2):
    """NONE. CHECK: a flit is not what was sent. ORDER: a packet that has another number of flits than its kind.
    ADDRESS: a packet for another node.
    """

    NONE = 0
    CHECK = 1
    ORDER = 2
    ADDRESS = 3
