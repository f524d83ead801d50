"""Faults of accesses to main memory."""

from amaranth.lib import enum
from amaranth.lib.data import StructLayout

__all__ = ["Fault", "fault_layout"]


class Fault(enum.Enum, shape=4):
    """Why a read or a write failed, or a table was refused.

    ``READ_OUTSIDE``, ``WRITE_OUTSIDE``: an address is outside the window, or no multiple of a beat; no transaction is
    issued. ``READ_REPLY``, ``WRITE_REPLY``: memory answered with an error. ``READ_TIMEOUT``, ``WRITE_TIMEOUT``: it did
    not answer. ``READ_PROTOCOL``, ``WRITE_PROTOCOL``: it answered no outstanding request, or with another number of
    beats. ``IMAGE``: no image, or one of another version. ``REGION``: a region lies outside the image, or has another
    number of records than it must have. ``POINTER``: a record points outside its table, or gives another length of it.
    ``NO_RECORD``: the hits of a section do not end with a row. ``SIZE``: a number of a record is too large for the
    machine. ``OVERFLOW``: a sum of weights is larger than its format.
    """

    NONE = 0
    READ_OUTSIDE = 1
    WRITE_OUTSIDE = 2
    READ_REPLY = 3
    WRITE_REPLY = 4
    READ_TIMEOUT = 5
    WRITE_TIMEOUT = 6
    READ_PROTOCOL = 7
    WRITE_PROTOCOL = 8
    IMAGE = 9
    REGION = 10
    POINTER = 11
    NO_RECORD = 12
    SIZE = 13
    OVERFLOW = 14


def fault_layout(address_bits: int) -> StructLayout:
    """A fault, and the address of the first byte of the beat, burst or record concerned."""
    return StructLayout({"code": Fault, "address": address_bits})
