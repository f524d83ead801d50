"""Write merge: several sources of writes at one port."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import claim
from hw.lib.queue import Queue
from hw.lib.round_robin import RoundRobin
from hw.lib.skid_buffer import SkidBuffer
from hw.lib.validate import check_integer
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["WriteMerge"]

# Requests whose data have not all left.
DEPTH = 4


class WriteMerge(wiring.Component):
    """Shares one port among several sources of writes. The number of a source is the tag of its requests.

    Requests are granted in round-robin order: one waits for at most ``count`` - 1 others. The data of the requests
    follow in the same order, so a source should offer a request when its data are there: no other source sends until
    they have left.

    No combinational path leads from an input to an output: grants, data and responses come from registers.

    Parameters
    ----------
    config
        The configuration.
    count
        Number of sources, at least 1.

    Members
    -------
    i_request : In, ``count`` streams of `MemoryFormats.request`
        Of the sources, without a tag.
    i_data : In, ``count`` streams of `MemoryFormats.write_data`
        Their beats in order. Those of a request are accepted after it.
    o_written : Out, ``count`` streams of `MemoryFormats.written`
        Their answers. A source that stalls its answers stalls those of the others.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_write``.
    o_data : Out, stream of `MemoryFormats.write_data`
        Its ``i_write_data``. While ``o_request`` stalls data may come before their request.
    i_written : In, stream of `MemoryFormats.written`
        Its ``o_written``.

    Timing
    ------
    Latency: ``2`` cycles from the offer of a request to the port, 1 of a beat, 1 of an answer. A source is granted at
    most every other cycle, another one in between; one beat per cycle, also from request to request of more than one
    beat; stalls with ``o_request``, ``o_data`` and ``o_written``; data of 4 requests in flight.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.
    """

    def __init__(self, *, config: Config, count: int):
        check_integer("Count", count, minimum=1)
        self._config, self._count, self._formats = config, count, MemoryFormats(config)
        formats, tag = self._formats, range(count)
        super().__init__({
            "i_request": In(stream.Signature(formats.request(0))).array(count),
            "i_data": In(stream.Signature(formats.write_data)).array(count),
            "o_written": Out(stream.Signature(formats.written(0))).array(count),
            "o_request": Out(stream.Signature(formats.request(tag))),
            "o_data": Out(stream.Signature(formats.write_data)),
            "i_written": In(stream.Signature(formats.written(tag)))})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        granted = self._add_requests(m)
        self._add_data(m, granted)
        # Answers.
        m.submodules.answers = answers = SkidBuffer(self.i_written.payload.shape())
        wiring.connect(m, wiring.flipped(self.i_written), answers.i)
        claim(m, ~self.i_written.valid | (self.i_written.payload.tag < self._count), "an answer is a source's")
        for number, answer in enumerate(self.o_written):
            m.d.comb += answer.payload.error.eq(answers.o.payload.error)
            with m.If(answers.o.payload.tag == number):
                m.d.comb += [answer.valid.eq(answers.o.valid), answers.o.ready.eq(answer.ready)]
        return m

    def _add_requests(self, m):
        """The requests at the port; the queue of sources and lengths of those that are granted."""
        count, request = self._count, self.o_request
        m.submodules.rule = rule = RoundRobin(count=count)
        m.submodules.requests = requests = Queue(request.payload.shape(), depth=DEPTH)
        m.submodules.order = order = Queue(StructLayout({
            "source": range(count), "length": self._config.memory.length_bits}), depth=DEPTH)
        wiring.connect(m, requests.o, wiring.flipped(request))
        # A grant is made a cycle before the transfer: an offer stays. There are entries for it, and for the one before.
        grant, entries = Signal(count), Signal()
        m.d.comb += [
            entries.eq((requests.level + grant.any() < DEPTH) & (order.level + grant.any() < DEPTH)),
            rule.accept.eq(rule.eligible.any()), requests.i.valid.eq(grant.any()), order.i.valid.eq(grant.any())]
        m.d.sync += grant.eq(rule.grant)
        given, kept = requests.i.payload, order.i.payload
        for k, source in enumerate(self.i_request):
            m.d.comb += [rule.request[k].eq(source.valid), rule.eligible[k].eq(source.valid & ~grant[k] & entries),
                         source.ready.eq(grant[k])]
            with m.If(grant[k]):
                m.d.comb += [given.address.eq(source.payload.address), given.length.eq(source.payload.length),
                             given.tag.eq(k), kept.source.eq(k), kept.length.eq(source.payload.length)]
        return order.o

    def _add_data(self, m, granted):
        """The data of the requests that are granted."""
        m.submodules.data = data = SkidBuffer(self.o_data.payload.shape())
        wiring.connect(m, data.o, wiring.flipped(self.o_data))
        # Whose data come, and how many beats after the next one.
        source, left = Signal(self._count), Signal(self._config.memory.length_bits, reset_less=True)
        takes, ends = data.i.valid & data.i.ready, Signal()
        m.d.comb += [ends.eq(takes & (left == 0)), granted.ready.eq(ends | (source == 0))]
        with m.If(takes):
            m.d.sync += left.eq(left - 1)
        with m.If(granted.ready):
            m.d.sync += [left.eq(granted.payload.length)]
            m.d.sync += [source[k].eq(granted.valid & (granted.payload.source == k)) for k in range(self._count)]
        for k, given in enumerate(self.i_data):
            m.d.comb += given.ready.eq(source[k] & data.i.ready)
            with m.If(source[k]):
                m.d.comb += [data.i.valid.eq(given.valid), data.i.payload.eq(given.payload)]
