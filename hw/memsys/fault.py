"""What can go wrong with main memory, and where."""

from amaranth.lib import enum
from amaranth.lib.data import StructLayout

__all__ = ["Fault", "fault_layout"]


class Fault(enum.Enum, shape=4):
    """Why a read or a write gave nothing, or a table was not taken.

    ``READ_OUTSIDE``, ``WRITE_OUTSIDE``: an address is outside the window, or no multiple of a beat; memory is not
    asked. ``READ_REPLY``, ``WRITE_REPLY``: memory answered with an error. ``READ_TIMEOUT``, ``WRITE_TIMEOUT``: it did
    not answer. ``READ_PROTOCOL``, ``WRITE_PROTOCOL``: it answered what nobody asked for, or with another number of
    beats. ``IMAGE``: no image, or one of another version. ``REGION``: a region lies outside the image, or has another
    number of records than it must have. ``POINTER``: a record points outside the table that it points into, or says
    another length of it. ``PLACE``: a result has no place in its region.
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
    PLACE = 12


def fault_layout(address_bits: int) -> StructLayout:
    """What went wrong, and the address of the first byte of the beat, burst or record that it went wrong with."""
    return StructLayout({"code": Fault, "address": address_bits})
