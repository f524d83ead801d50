"""Store lookup: what a request meets in its frame, and what follows."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.memsys.patches.patch_store import KEPT_OF
from hw.formats import Formats
from hw.lib.generations import Generations
from hw.lib.queue import Queue
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.patches.store_formats import StoreFormats

__all__ = ["StoreLookup"]


class StoreLookup(wiring.Component):
    """Gives each request the lowest free entry, and decides whether it is fetched and whether it is kept.

    A request that meets its patch is not fetched. One that meets an empty frame renews it, and so does every
    `KEPT_OF`-th of those that meet another patch; both are kept, the others passed on. A frame with a request in flight
    is not renewed: the request waits.

    Parameters
    ----------
    config, frames, requests
        See `PatchStore`.

    Members
    -------
    i_start : In, stream without payload
        Empties all frames.
    is_open : In(1)
        Requests are accepted.
    i : In, stream of `PathFormats.store_request`
        Requests. Accepted while an entry is free and no frame is being forgotten.
    taken : In(requests)
        Entries in flight.
    i_forget : In, stream of a frame
        A frame that becomes empty.
    entries : Out(StoreFormats.entries)
        Each entry's request, until the next one takes it.
    takes, fetches : Out(requests)
        The entry that a request takes in this cycle, and the same if it is fetched, one-hot or 0.
    busy : Out(1)
        A request is being looked up.
    o_renew : Out, stream of a frame
        The frame's next patch will be the request's.
    o_read : Out, stream of ``address``, ``tag``
        Frame and entry of a request that is kept.
    o_fetch : Out, stream of `PathFormats.store_request`
        Patches to fetch.
    hits : Out(32)
        Requests without a fetch, since reset.

    Timing
    ------
    Latency: ``3`` cycles from a request to ``o_read`` and ``o_fetch``. One request every three cycles, if its frame is
    not in flight.

    Golden counterpart: `golden.engine.memsys.patches.patch_store.PatchStore`.
    """

    latency = 3

    def __init__(self, *, config: Config, frames: int, requests: int):
        self._formats = formats = StoreFormats(config=config, frames=frames, requests=requests)
        self._frames, self._requests, self._patch = frames, requests, Formats(config).patch
        request = stream.Signature(PathFormats(config).store_request)
        access = StructLayout({"address": formats.frame, "tag": formats.number})
        super().__init__({
            "i_start": In(stream.Signature(0)), "is_open": In(1), "i": In(request), "taken": In(requests),
            "i_forget": In(stream.Signature(formats.frame)), "entries": Out(formats.entries), "takes": Out(requests),
            "fetches": Out(requests), "busy": Out(1), "o_renew": Out(stream.Signature(formats.frame)),
            "o_read": Out(stream.Signature(access)), "o_fetch": Out(request), "hits": Out(32)})

    def elaborate(self, platform):
        m, formats = Module(), self._formats
        m.submodules.generations = generations = Generations(bits=formats.version_bits, depth=self._frames)
        tag = StructLayout({"generation": formats.version_bits, "patch": self._patch})
        m.submodules.tags = tags = Memory(shape=tag, depth=self._frames, init=[], attrs={"no_rw_check": 1})
        wiring.connect(m, wiring.flipped(self.i_start), generations.i_start)
        m.submodules.to_fetch = to_fetch = Queue(self.i.payload.shape(), depth=self._requests)
        m.submodules.to_read = to_read = Queue(self.o_read.payload.shape(), depth=self._requests)
        wiring.connect(m, to_fetch.o, wiring.flipped(self.o_fetch))
        wiring.connect(m, to_read.o, wiring.flipped(self.o_read))

        request, frame_bits = Signal.like(self.i.payload), self._frames.bit_length() - 1
        entries = Signal(formats.entries, reset_less=True)
        frame, free, number = Signal(formats.frame), Signal(self._requests), Signal(formats.number)
        matches, empty, in_use, acts, renews, keeps = (Signal(name=name) for name in (
            "matches", "empty", "in_use", "acts", "renews", "keeps"))
        # Requests that have met another patch, since the store was emptied.
        conflicts = Signal(range(KEPT_OF))
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += conflicts.eq(0)
        read, write, taken, forget = tags.read_port(), tags.write_port(), self.taken, self.i_forget
        # Registered: what a request meets is known in the third cycle, and no other request is looked up meanwhile.
        # ``in_use`` lags behind by a cycle, in which a frame can only become free.
        uses = [taken[k] & entries[k].is_stored & (entries[k].frame == frame) for k in range(self._requests)]
        m.d.sync += in_use.eq(Cat(uses).any())
        m.d.comb += [
            self.entries.eq(entries), self.busy.eq(1),
            frame.eq(request.patch[:frame_bits]), free.eq(~taken & (taken + 1)[:self._requests]),
            read.addr.eq(self.i.payload.patch[:frame_bits]),
            renews.eq(~matches & (empty | (conflicts == KEPT_OF - 1))), keeps.eq(matches | renews),
            to_fetch.i.payload.eq(request), to_read.i.payload.address.eq(frame), to_read.i.payload.tag.eq(number),
            self.o_renew.payload.eq(frame),
            write.addr.eq(Mux(generations.sweeps, generations.row, Mux(acts, frame, forget.payload))),
            write.data.patch.eq(request.patch), write.data.generation.eq(Mux(acts, generations.generation, 0)),
            write.en.eq(generations.sweeps | (forget.valid & forget.ready) | (acts & renews))]
        # The frame of a lost patch is forgotten between two lookups, and while one waits for its frame.
        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [self.busy.eq(0), self.i.ready.eq(self.is_open & ~taken.all() & ~forget.valid),
                             forget.ready.eq(~generations.sweeps)]
                m.d.sync += request.eq(self.i.payload)
                with m.If(self.i.valid & self.i.ready):
                    m.next = "Compare"
            with m.State("Compare"):
                m.d.sync += [
                    matches.eq((read.data.generation == generations.generation) & (read.data.patch == request.patch)),
                    empty.eq(read.data.generation != generations.generation),
                    number.eq(sum(Mux(free[k], k, 0) for k in range(self._requests)))]
                m.next = "Act"
            # A fill cannot come before its frame has been renewed, however long reads stall.
            with m.State("Act"):
                m.d.comb += [self.o_renew.valid.eq(renews & ~in_use), forget.ready.eq(~generations.sweeps & ~acts),
                             acts.eq(~renews | (self.o_renew.ready & ~in_use))]
                with m.If(acts):
                    m.d.comb += [self.takes.eq(1 << number), self.fetches.eq(Mux(matches, 0, self.takes)),
                                 to_fetch.i.valid.eq(~matches), to_read.i.valid.eq(keeps)]
                    m.d.sync += [
                        entries[number].patch.eq(request.patch), entries[number].frame.eq(frame),
                        entries[number].is_stored.eq(keeps), self.hits.eq(self.hits + matches),
                        conflicts.eq(conflicts + (~matches & ~empty))]
                    m.next = "Wait"
        return m
