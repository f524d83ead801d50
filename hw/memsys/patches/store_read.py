"""Store read: the frames' patches to those who wait for them."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES, Formats
from hw.lib.pipeline import Pipeline
from hw.memsys.patches.store_formats import StoreFormats

__all__ = ["StoreRead"]


class StoreRead(wiring.Component):
    """Holds the frames, and reads one for each request whose patch is there.

    A frame with a lost patch, or with one whose vertices are all 0, is forgotten.

    Parameters
    ----------
    config, frames, requests
        See `PatchStore`.

    Members
    -------
    write : Out(StoreFormats.write)
        Writes vertices into frames.
    i : In, stream of ``tag``, ``data``
        An entry whose patch is in its frame, and what is known of it.
    entries : In(StoreFormats.entries)
        Each entry's request.
    o : Out, stream of `Formats.patch_vertex`
        The vertices of its patch.
    o_forget : Out, stream of a frame
        A frame that becomes empty.
    frees : Out(requests)
        The entry whose request ends in this cycle, one-hot or 0.
    lost : Out(1)
        A request has ended without a patch.

    Timing
    ------
    Latency: ``2`` cycles from an entry to its first vertex. One vertex per cycle; stalls with ``o`` and ``o_forget``.

    Golden counterpart: `golden.engine.memsys.patches.patch_store.PatchStore`.
    """

    latency = 2

    def __init__(self, *, config: Config, frames: int, requests: int):
        self._formats = store = StoreFormats(config=config, frames=frames, requests=requests)
        self._frames, formats = frames, Formats(config)
        self._patch = formats.patch
        super().__init__({
            "write": Out(store.write), "entries": In(store.entries),
            "i": In(stream.Signature(StructLayout({"tag": store.number, "data": store.head}))),
            "o": Out(stream.Signature(formats.patch_vertex)), "o_forget": Out(stream.Signature(store.frame)),
            "frees": Out(requests), "lost": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.vertices = vertices = Memory(
            shape=self._formats.vertex, depth=VERTICES * self._frames, init=[], attrs={"no_rw_check": 1})
        wiring.connect(m, wiring.flipped(self.write), vertices.write_port())
        step = StructLayout({"index": range(VERTICES), "frame": self._formats.frame, "patch": self._patch})
        steps = stream.Signature(step).create(path=("steps",))
        pipeline = Pipeline(steps, self.o)
        given, out = steps.payload, self.o.payload
        address = pipeline.combine(lambda index, frame: Cat(index, frame), pipeline.input(given.index),
                                   pipeline.input(given.frame))
        read = pipeline.delay(pipeline.read(vertices.read_port(), address), 1)
        for axis in range(3):
            pipeline.output(out.vertex[axis], pipeline.combine(lambda read, axis=axis: read.vertex[axis], read))
        pipeline.output(out.surface, pipeline.combine(lambda read: read.surface, read))
        pipeline.output(out.patch, pipeline.input(given.patch))
        pipeline.add_to(m)

        index, ends, forget = Signal(range(VERTICES)), Signal(), self.o_forget
        entry, head, is_last = Signal(self._formats.entry), self.i.payload.data, index == VERTICES - 1
        # What leaves a frame without a patch leaves as soon as that is forgotten; to forget it twice does no harm.
        waits = is_last & head.is_void & ~forget.ready
        m.d.comb += [
            entry.eq(self.entries[self.i.payload.tag]), given.index.eq(index), given.frame.eq(entry.frame),
            given.patch.eq(entry.patch), steps.valid.eq(self.i.valid & ~head.is_lost & ~waits),
            forget.valid.eq(self.i.valid & (head.is_lost | (is_last & head.is_void))), forget.payload.eq(entry.frame),
            ends.eq(Mux(head.is_lost, forget.ready, steps.ready & is_last & ~waits)), self.i.ready.eq(ends),
            self.frees.eq(Mux(self.i.valid & ends, 1 << self.i.payload.tag, 0))]
        with m.If(steps.valid & steps.ready):
            m.d.sync += index.eq(index + 1)
        m.d.sync += self.lost.eq(self.i.valid & head.is_lost & forget.ready)
        return m
