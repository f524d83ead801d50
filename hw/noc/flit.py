"""Flits, and the payloads of links."""

from amaranth.lib.data import StructLayout

__all__ = ["flit", "link"]


def flit(bits: int) -> StructLayout:
    """A flit: ``first`` and ``last`` of its packet. The lowest bits of a first flit's data are the destination."""
    return StructLayout({"data": bits, "first": 1, "last": 1})


def link(bits: int, channels: int) -> StructLayout:
    """A flit and its virtual channel."""
    return StructLayout({"flit": flit(bits), "channel": range(channels)})
