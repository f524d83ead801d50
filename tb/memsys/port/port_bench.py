"""The testbench of main memory's port."""

import random

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge

from hw.lib.payload import pack, unpack
from hw.memsys.port.fault import Fault
from hw.memsys.port.main_memory_port import MainMemoryPort
from hw.memsys.port.memory_formats import MemoryFormats
from tb.lib.configurations import config_of
from tb.lib.runner import options
from tb.lib.scoreboard import check
from tb.lib.stall_patterns import STALLS
from tb.lib.stream import Sink, Source

__all__ = ["BASE", "READ", "SMALL", "STREAMS", "TAG", "WRITE", "Bench", "content"]

STREAMS = ("i_read", "o_read", "i_write", "i_write_data", "o_written")
TAG = 6
# Where the memory is, how much of it may be read, and how much of that may be written.
BASE, SIZE = 0x12_3450_0000, 0x4000
READ, WRITE = (BASE + 0x40, BASE + SIZE - 0x40), (BASE + 0x2000, BASE + SIZE - 0x100)
SMALL = {"memory.outstanding": 4, "memory.burst_beats": 8, "memory.length_bits": 6, "memory.timeout_bits": 8}


def content(seed=0):
    """Bytes of the memory."""
    return random.Random(seed).randbytes(SIZE)


class Bench:
    """The port's clients."""

    def __init__(self, dut, source="none", sink="none"):
        self.dut, self.config = dut, config_of(options()["changes"])
        self.seed = options()["seed"]
        self.random = random.Random(self.seed)
        self.bytes, self.formats = self.config.memory.beat_bytes, MemoryFormats(self.config)
        members = MainMemoryPort(config=self.config, tag=TAG).signature.members
        self.shapes = {name: members[name].signature.members["payload"].shape for name in STREAMS}
        dut.read_window.value = pack(self.formats.window, dict(zip(("base", "limit"), READ, strict=True)))
        dut.write_window.value = pack(self.formats.window, dict(zip(("base", "limit"), WRITE, strict=True)))
        dut.clear.value = 0
        self.reads, self.writes, self.data = (
            Source(dut, name, stalls=STALLS[source](self.seed + k))
            for k, name in enumerate(("i_read", "i_write", "i_write_data")))
        self.replies, self.written = (Sink(dut, name, stalls=STALLS[sink](self.seed + 7 + k))
                                      for k, name in enumerate(("o_read", "o_written")))
        self._tasks = []

    def start(self, source, items):
        """Send items while other things happen."""
        self._tasks.append(cocotb.start_soon(self.send(source, items)))
        return self._tasks[-1]

    def stop(self):
        """Take nothing more, and give nothing."""
        for task in self._tasks:
            task.cancel()
        for source in (self.reads, self.writes, self.data):
            source.valid.value = 0
        self.replies.stop()
        self.written.stop()

    def request(self, window, beats=None):
        """One within a window, often at its ends or over several pages."""
        most = 1 << self.config.memory.length_bits
        beats = beats or self.random.choice((1, 1, 2, 5, self.config.memory.burst_beats, most,
                                             self.random.randint(1, most)))
        low, high = window[0] // self.bytes, window[1] // self.bytes - beats
        first = self.random.choice((low, high, *(self.random.randint(low, high) for _ in range(8))))
        return {"address": first * self.bytes, "length": beats - 1, "tag": self.random.randrange(1 << TAG)}

    def expected(self, request, data, failed=lambda address: False):
        """The replies to a read. A burst of which a beat failed is an error altogether."""
        beats, beat_bytes = request["length"] + 1, self.bytes
        addresses = [request["address"] + k * beat_bytes for k in range(beats)]
        size = self.config.memory.burst_beats * beat_bytes
        bad = {at // size for at in addresses if failed(at)}
        return [{"data": int.from_bytes(data[at - BASE:at - BASE + beat_bytes], "little"), "tag": request["tag"],
                 "last": k == beats - 1, "error": at // size in bad} for k, at in enumerate(addresses)]

    def to_write(self, requests, data):
        """Beats for requests, some bytes not enabled; ``data`` is changed as memory must be."""
        beats = []
        for request in requests:
            for k in range(request["length"] + 1):
                word = self.random.randbytes(self.bytes)
                strobe = self.random.choice(((1 << self.bytes) - 1, self.random.getrandbits(self.bytes)))
                beats.append({"data": int.from_bytes(word, "little"), "strobe": strobe})
                at = request["address"] - BASE + k * self.bytes
                for lane in range(self.bytes):
                    if strobe >> lane & 1:
                        data[at + lane] = word[lane]
        return beats

    async def send(self, source, items):
        """Send items to a source."""
        await source.send([pack(self.shapes[source.name], item) for item in items])

    async def arrive(self, sink, count):
        """Wait until so many items are in a sink, and a little longer."""
        while len(sink.items) < count:
            await RisingEdge(self.dut.clk)
        await ClockCycles(self.dut.clk, 8)

    def compare(self, sink, expected):
        """Data of errors are not compared."""
        shape = self.shapes[sink.name]
        got = [unpack(shape, item) for item in sink.items]
        for item, required in zip(got, expected, strict=False):
            if item["error"] and required["error"] and "data" in item:
                item["data"] = required["data"]
        check(shape, [pack(shape, item) for item in got], [pack(shape, item) for item in expected], what=sink.name)

    def fault(self):
        """The code of the fault that stands, and its address."""
        found = unpack(self.formats.fault, int(self.dut.fault.value))
        return Fault(found["code"]), found["address"]

    async def clear(self):
        """Clear the fault."""
        self.dut.clear.value = 1
        await RisingEdge(self.dut.clk)
        self.dut.clear.value = 0
        await ClockCycles(self.dut.clk, 2)
        assert self.fault()[0] is Fault.NONE

    async def exchange(self, model, count, failed=lambda address: False):
        """Reads and writes at once, of parts that do not overlap; everything comes as it must."""
        low = (READ[0], WRITE[0])
        reads, writes = ([self.request(window) for _ in range(count)] for window in (low, WRITE))
        before, after = bytes(model.data), bytearray(model.data)
        beats = self.to_write(writes, after)
        tasks = [self.start(source, items) for source, items in (
            (self.reads, reads), (self.writes, writes), (self.data, beats))]
        replies = [beat for request in reads for beat in self.expected(request, before, failed)]
        await self.arrive(self.replies, len(replies))
        await self.arrive(self.written, len(writes))
        for task in tasks:
            await task
        self.compare(self.replies, replies)
        self.compare(self.written, [{"tag": request["tag"], "error": any(
            beat["error"] for beat in self.expected(request, before, failed))} for request in writes])
        assert not int(self.dut.busy.value)
        return after
