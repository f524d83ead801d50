"""Beat writer: beats to main memory, in requests whose data are all there."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import count_steps
from hw.lib.queue import Queue
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.results.result_formats import LANE_BITS, ResultFormats, lanes_of

__all__ = ["GROUP_BITS", "BeatWriter"]

# A request has at most 2^4 beats; 2^5 beats wait.
GROUP_BITS, DEPTH = 4, 32
# Requests that wait, and requests that have no answer.
REQUESTS = 16


class BeatWriter(wiring.Component):
    """Makes one request of the beats up to one that ``ends`` it, and offers it when all of them are in its queue: who
    shares the port never waits for data.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `ResultFormats.beat`
        Beats. The beats of a request are consecutive and lie in one aligned group of at most 16.
    discard : In(1)
        No further request is offered; beats without a request are dropped.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_write``.
    o_data : Out, stream of `MemoryFormats.write_data`
        Its ``i_write_data``: beats of requests that have been accepted.
    i_written : In, stream of `MemoryFormats.written`, always ready
        Its ``o_written``.
    failed : Out(1)
        The answer that comes is an error.
    address : Out(address_bits)
        With ``failed``: that of the request's first beat.
    idle : Out(1)
        No beat is inside, and every request has been answered.

    Timing
    ------
    Latency: ``1`` cycle from the last beat of a request to the request. One beat and one request per cycle; stalls with
    ``o_request`` and ``o_data``, and while 16 requests have no answer. 32 beats and 16 requests wait.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats, self._memory = config, ResultFormats(config), MemoryFormats(config)
        memory = self._memory
        super().__init__({
            "i": In(stream.Signature(self._formats.beat)), "discard": In(1),
            "o_request": Out(stream.Signature(memory.request(0))), "o_data": Out(stream.Signature(memory.write_data)),
            "i_written": In(stream.Signature(memory.written(0), always_ready=True)),
            "failed": Out(1), "address": Out(config.memory.address_bits), "idle": Out(1)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        memory, lanes, low = self._config.memory, lanes_of(self._config), self._memory.low_bits
        number = len(self.i.payload.number)
        m.submodules.beats = beats = Queue(
            StructLayout({"data": memory.data_bits, "lanes": lanes, "ends": 1}), depth=DEPTH)
        m.submodules.requests = requests = Queue(
            StructLayout({"first": number, "length": GROUP_BITS}), depth=REQUESTS)
        # First beats of the requests without an answer.
        m.submodules.outstanding = outstanding = Queue(number, depth=REQUESTS)

        # Beats of the request that is being made; one before the present beat.
        beat, length = self.i.payload, Signal(GROUP_BITS)
        takes = self.i.valid & self.i.ready & ~self.discard
        m.d.comb += [
            self.i.ready.eq(beats.i.ready & requests.i.ready), beats.i.valid.eq(takes),
            requests.i.valid.eq(takes & beat.ends), requests.i.payload.length.eq(length),
            # A request does not leave its group: its beats differ in the lowest bits alone.
            requests.i.payload.first.eq(Cat((beat.number - length)[:GROUP_BITS], beat.number[GROUP_BITS:]))]
        m.d.comb += [beats.i.payload[name].eq(beat[name]) for name in ("data", "lanes", "ends")]
        with m.If(self.discard):
            m.d.sync += length.eq(0)
        with m.Elif(takes):
            m.d.sync += length.eq(Mux(beat.ends, 0, length + 1))

        # An offer stays, whatever has failed meanwhile.
        offered, accepts = Signal(), Signal()
        request, head = self.o_request, requests.o
        m.d.comb += [
            request.valid.eq(offered | (head.valid & outstanding.i.ready & ~self.discard)),
            request.payload.address.eq(Cat(Const(0, low), head.payload.first)),
            request.payload.length.eq(head.payload.length), accepts.eq(request.valid & request.ready),
            head.ready.eq(accepts | (self.discard & ~offered)),
            outstanding.i.valid.eq(accepts), outstanding.i.payload.eq(head.payload.first)]
        m.d.sync += offered.eq(request.valid & ~request.ready)

        # Requests that have been accepted, and not all of whose beats have left.
        granted, data = Signal(range(REQUESTS + 1)), self.o_data
        sends = data.valid & data.ready & beats.o.payload.ends
        count_steps(m, granted, up=accepts, down=sends, most=REQUESTS)
        m.d.comb += [
            data.valid.eq(granted.any()), data.payload.data.eq(beats.o.payload.data),
            data.payload.strobe.eq(Cat(lane.replicate(LANE_BITS // 8) for lane in beats.o.payload.lanes)),
            beats.o.ready.eq(Mux(granted.any(), data.ready, self.discard & ~offered))]

        answer = self.i_written
        m.d.comb += [
            outstanding.o.ready.eq(answer.valid),
            self.failed.eq(answer.valid & answer.payload.error & outstanding.o.valid),
            self.address.eq(Cat(Const(0, low), outstanding.o.payload)),
            self.idle.eq(~beats.o.valid & ~requests.o.valid & ~outstanding.o.valid)]
        return m
