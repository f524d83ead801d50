"""Streams of structs whose sink is always ready."""

from collections.abc import Mapping

from amaranth.lib import stream
from amaranth.lib.data import StructLayout

__all__ = ["struct_stream"]


def struct_stream(fields: Mapping) -> stream.Signature:
    """The signature of a stream that is always ready and whose items have these fields."""
    return stream.Signature(StructLayout(dict(fields)), always_ready=True)
