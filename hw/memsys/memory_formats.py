"""Payloads of the streams to and from main memory."""

from amaranth.lib.data import StructLayout

from golden.config import Config
from hw.memsys.fault import fault_layout

__all__ = ["MemoryFormats"]

# Of a window's bounds, whatever the width of an address.
WINDOW_BITS = 64


class MemoryFormats:
    """All layouts of one configuration.

    A *beat* is ``data_bits`` wide, and has a number: its address without the bits inside it. What counts beats counts
    those after the first one, so that there is always one at least.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    low_bits, beat_bits, burst_bits, slot_bits
        Bits of a byte's place in its beat, of a beat's number, of its place in a burst, and of a burst under way.
    fault, window
        See `hw.memsys.fault`; ``base`` <= address < ``limit``, of 64 bits as in the registers.
    write_data, written
        ``data`` and ``strobe``, a bit per byte; ``tag`` and ``error``.
    """

    def __init__(self, config: Config):
        memory = self.memory = config.memory
        self.low_bits = memory.beat_bytes.bit_length() - 1
        self.beat_bits = memory.address_bits - self.low_bits
        self.burst_bits = memory.burst_beats.bit_length() - 1
        self.slot_bits = max(1, memory.outstanding.bit_length() - 1)
        self.fault = fault_layout(memory.address_bits)
        self.window = StructLayout({"base": WINDOW_BITS, "limit": WINDOW_BITS})
        self.write_data = StructLayout({"data": memory.data_bits, "strobe": memory.beat_bytes})

    def request(self, tag) -> StructLayout:
        """Address of a byte, beats after the first one, and what comes back with the answer."""
        return StructLayout({"address": self.memory.address_bits, "length": self.memory.length_bits, "tag": tag})

    def checked(self, tag) -> StructLayout:
        """First and last beat of a request, and whether it must not be made."""
        return StructLayout({"first": self.beat_bits, "last": self.beat_bits, "tag": tag, "bad": 1})

    def burst(self, tag) -> StructLayout:
        """A part of a request; ``ends`` it."""
        return StructLayout({"first": self.beat_bits, "length": self.burst_bits, "tag": tag, "ends": 1, "bad": 1})

    def reply(self, tag) -> StructLayout:
        """A beat; ``last`` of its request. Data with an error mean nothing."""
        return StructLayout({"data": self.memory.data_bits, "tag": tag, "last": 1, "error": 1})

    def written(self, tag) -> StructLayout:
        """A request has been written, or not."""
        return StructLayout({"tag": tag, "error": 1})

    @property
    def address(self) -> StructLayout:
        """An AXI burst: its id, first beat, and beats after that."""
        return StructLayout({"id": self.slot_bits, "first": self.beat_bits, "length": self.burst_bits})

    @property
    def read_data(self) -> StructLayout:
        """An AXI beat that was read."""
        return StructLayout({"id": self.slot_bits, "data": self.memory.data_bits, "response": 2, "last": 1})

    @property
    def wire_data(self) -> StructLayout:
        """An AXI beat to be written."""
        return StructLayout({"data": self.memory.data_bits, "strobe": self.memory.beat_bytes, "last": 1})

    @property
    def response(self) -> StructLayout:
        """An AXI answer to a write."""
        return StructLayout({"id": self.slot_bits, "response": 2})
