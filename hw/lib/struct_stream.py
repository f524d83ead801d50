"""Streams of structs."""

from collections.abc import Mapping

from amaranth.lib import stream
from amaranth.lib.data import StructLayout

__all__ = ["struct_stream"]


def struct_stream(fields: Mapping, *, always_ready: bool = False) -> stream.Signature:
    """The signature of a stream whose items have these fields."""
    return stream.Signature(StructLayout(dict(fields)), always_ready=always_ready)
