"""Payloads of the streams to and from main memory."""

from amaranth.hdl import Cat, Value
from amaranth.lib.data import StructLayout

from golden.engine.config import Config
from golden.engine.memory_map import REGIONS
from hw.memsys.load.image_layout import COUNT_BITS, RECORD_WORDS, WORD_BITS, RegionNumber
from hw.memsys.port.fault import fault_layout

__all__ = ["MemoryFormats", "saturated"]

# Of a window's bounds, whatever the width of an address.
WINDOW_BITS = 64
# Of an extent of words: a region of 2^COUNT_BITS records has more words.
LENGTH_BITS = 36


def saturated(total: Value, bits: int) -> Value:
    """A sum of addresses, or of numbers of beats, in one bit more than they have: past the end of memory it stays."""
    return Cat(total[:bits], total[bits:].any())


class MemoryFormats:
    """All layouts of one configuration.

    A *beat* is ``data_bits`` wide. Its number is its address without the bits inside it. A *length* is the number of
    items after the first one: there is always at least one. An address that is requested has one bit more than one in
    memory.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    low_bits, beat_bits, burst_bits, slot_bits
        Bits of the address of a byte in its beat, of the number of a beat, of its index in a burst, and of the number
        of an outstanding burst.
    """

    def __init__(self, config: Config):
        memory = self.memory = config.memory
        self.low_bits = memory.beat_bytes.bit_length() - 1
        self.beat_bits = memory.address_bits - self.low_bits
        self.burst_bits = memory.burst_beats.bit_length() - 1
        self.slot_bits = max(1, memory.outstanding.bit_length() - 1)
        #: `hw.memsys.port.fault.fault_layout`.
        self.fault = fault_layout(memory.address_bits)
        #: ``base`` <= address < ``limit``, of 64 bits as in the registers.
        self.window = StructLayout({"base": WINDOW_BITS, "limit": WINDOW_BITS})
        #: ``data`` and ``strobe``, a bit per byte.
        self.write_data = StructLayout({"data": memory.data_bits, "strobe": memory.beat_bytes})
        #: An AXI burst: its id, first beat, and length.
        self.address = StructLayout({"id": self.slot_bits, "first": self.beat_bits, "length": self.burst_bits})
        #: An AXI beat of a read.
        self.read_data = StructLayout({"id": self.slot_bits, "data": memory.data_bits, "response": 2, "last": 1})
        #: An AXI beat of a write.
        self.wire_data = StructLayout({"data": memory.data_bits, "strobe": memory.beat_bytes, "last": 1})
        #: An AXI answer to a write.
        self.response = StructLayout({"id": self.slot_bits, "response": 2})
        #: Consecutive words: their address, length, and whether they are ``narrow``, of 32 bits.
        self.read_extent = StructLayout({"address": memory.address_bits + 1, "length": LENGTH_BITS, "narrow": 1})
        #: A word, the ``last`` one of its extent or not. With ``error`` the data are undefined.
        self.word = StructLayout({"data": WORD_BITS, "last": 1, "error": 1})
        #: A word of a memory image: its region, its record from 0 on, and its number in the record.
        self.table_word = StructLayout({"region": RegionNumber, "record": COUNT_BITS, "word": range(max(RECORD_WORDS)),
                                        "data": WORD_BITS})
        #: A region of a memory image: the address and the number of its records.
        self.table = StructLayout({"address": memory.address_bits, "count": COUNT_BITS})
        #: A command of the preload DMA: address of the image, cluster, and a bit for each region.
        self.preload = StructLayout({"image": memory.address_bits, "cluster": 16, "regions": len(REGIONS)})

    def request(self, tag) -> StructLayout:
        """Address of the first byte, length in beats, and a sideband tag that returns with the answer."""
        return StructLayout({"address": self.memory.address_bits + 1, "length": self.memory.length_bits, "tag": tag})

    def checked(self, tag) -> StructLayout:
        """First and last beat of a request; of a ``bad`` one no transaction is issued."""
        return StructLayout({"first": self.beat_bits, "last": self.beat_bits, "tag": tag, "bad": 1})

    def burst(self, tag) -> StructLayout:
        """A part of a request; ``ends`` marks the last one."""
        return StructLayout({"first": self.beat_bits, "length": self.burst_bits, "tag": tag, "ends": 1, "bad": 1})

    def reply(self, tag) -> StructLayout:
        """A beat, the ``last`` one of its request or not. With ``error`` the data are undefined."""
        return StructLayout({"data": self.memory.data_bits, "tag": tag, "last": 1, "error": 1})

    def written(self, tag) -> StructLayout:
        """A request has been written; with ``error`` it has not."""
        return StructLayout({"tag": tag, "error": 1})
