"""Local patch geometry: the resident set of a cluster."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.pipeline import Pipeline
from hw.lib.shared_port import share_port
from hw.memsys.patch_decoder import PatchDecoder
from hw.memsys.path_formats import PathFormats

__all__ = ["LocalPatchGeometry"]


class LocalPatchGeometry(wiring.Component):
    """Patches by local address, for this cluster and for others: the four vertices of a patch, one after the other.

    A patch that is asked for but is not there comes with four vertices of 0, as a patch that nothing hits, and the
    fault is told.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load
        `PathFormats.geometry_load`: the first six words of each patch in their order. Always ready; not while patches
        are under way. Addresses that there are not here are ignored.
    i, o
        ``patch`` and local ``address``; `Formats.patch_vertex`.
    i_asked, o_asked
        ``node`` and ``place``, a `PathFormats.found_patch`; ``node`` and ``vertex``. What is not held by this cluster,
        of number ``cluster``, is not there.
    cluster
        See above. The same while patches are under way.
    wrong, asked_wrong
        The patch ``number``, or ``asked_number``, is not there. In the cycle after its first vertex has gone on.

    Timing
    ------
    Latency: ``4`` cycles to the first vertex. One vertex per cycle on each side, without a gap between patches; stalls
    with its output.

    Source: Shen 1993, section 5.3.6.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats, self._icu = config, PathFormats(config), Formats(config)
        formats, icu, node = self._formats, self._icu, config.noc.node_bits
        super().__init__({
            "i_load": In(stream.Signature(formats.geometry_load, always_ready=True)),
            "i": In(stream.Signature(StructLayout({"patch": icu.patch, "address": formats.place_bits}))),
            "o": Out(stream.Signature(icu.patch_vertex)),
            "i_asked": In(stream.Signature(StructLayout({"node": node, "place": formats.found_patch}))),
            "o_asked": Out(stream.Signature(StructLayout({"node": node, "vertex": icu.patch_vertex}))),
            "cluster": In(formats.cluster), "wrong": Out(1), "number": Out(icu.patch), "asked_wrong": Out(1),
            "asked_number": Out(icu.patch)})
        places = config.memsys.own_patches
        self._vertices = Memory(shape=icu.scene_vector, depth=4 * places, init=[], attrs={"no_rw_check": 1})
        self._heads = Memory(shape=formats.patch_head, depth=places, init=[], attrs={"no_rw_check": 1})
        own, asked = self.i.payload, self.i_asked.payload
        place, cluster = asked.place, self.cluster
        self._sides = [
            _Side(self, own.patch, own.address, 1, self.i, self.o, self.o.payload, self.wrong, self.number),
            _Side(self, place.patch, place.address, place.is_held & ~place.wrong & (place.cluster == cluster),
                  self.i_asked, self.o_asked, self.o_asked.payload.vertex, self.asked_wrong, self.asked_number,
                  node=(asked.node, self.o_asked.payload.node))]
        self.latency = 1 + self._sides[0].pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.vertices, m.submodules.heads = self._vertices, self._heads
        for side in self._sides:
            side.add_to(m)
        self._add_load(m)
        return m

    def _add_load(self, m):
        """Heads, and vertices as they are decoded."""
        given, address_bits = self.i_load.payload, self._formats.place_bits
        m.submodules.decoder = decoder = PatchDecoder(config=self._config)
        vertex, head = (Signal(StructLayout({"enable": 1, "address": range(memory.depth), "data": memory.shape}),
                               name=name) for name, memory in (("vertex", self._vertices), ("head", self._heads)))
        known = self.i_load.valid & (given.address[address_bits:] == 0)
        m.d.comb += [decoder.valid.eq(self.i_load.valid), decoder.word.eq(given.word), decoder.data.eq(given.record)]
        m.d.sync += [
            head.enable.eq(known & (given.word == 0)), head.address.eq(given.address),
            head.data.patch.eq(decoder.patch), head.data.surface.eq(decoder.surface),
            vertex.enable.eq(known & (given.word >= 2)),
            vertex.address.eq(Cat(decoder.index, given.address[:address_bits])), vertex.data.eq(decoder.vertex)]
        remote = self._sides[1]
        for memory, read, write in (self._vertices, remote.vertices, vertex), (self._heads, remote.heads, head):
            share_port(read, m, memory.write_port(), enable=write.enable, address=write.address, data=write.data)


class _Side:
    """One who asks: the walk over the four vertices of a patch, and what is read."""

    def __init__(self, of, patch, address, there, i, o, vertex, wrong, number, *, node=None):
        self._i, self._wrong, self._number, self._shown = i, wrong, number, vertex
        formats, icu = of._formats, of._icu
        shape = {"patch": icu.patch, "address": formats.place_bits, "there": 1}
        self._given = {"patch": patch, "address": address, "there": there}
        if node is not None:
            shape["node"], self._given["node"] = node[0].shape(), node[0]
        self._steps = stream.Signature(StructLayout({"index": 2, **shape})).create()
        self.pipeline = pipeline = Pipeline(self._steps, o)
        step = {name: pipeline.input(self._steps.payload[name]) for name in ("index", *shape)}
        beat = pipeline.combine(lambda index, address: Cat(index, address), step["index"], step["address"])
        self.vertices, self.heads = of._vertices.read_port(), of._heads.read_port()
        read = pipeline.delay(pipeline.read(self.vertices, beat), 1)
        head = pipeline.delay(pipeline.read(self.heads, step["address"]), 1)
        there = pipeline.register(lambda there, head, patch: there & (head.patch == patch), step["there"], head,
                                 step["patch"])
        pipeline.output(vertex.patch, step["patch"])
        pipeline.output(vertex.surface, pipeline.combine(lambda head: head.surface, head))
        for axis in range(3):
            pipeline.output(vertex.vertex[axis], pipeline.combine(
                lambda read, there, axis=axis: read[axis] & there.replicate(len(read[axis])), read, there))
        if node is not None:
            pipeline.output(node[1], step["node"])
        self._first, self._there = pipeline.align(step["index"], there)

    def add_to(self, m):
        """The walk and the pipeline."""
        steps, given = self._steps, self._i
        busy, kept, index = Signal(), Signal.like(steps.payload, reset_less=True), steps.payload.index
        m.d.comb += [steps.valid.eq(busy), steps.payload.eq(kept),
                     given.ready.eq(~busy | (steps.ready & (index == 3)))]
        with m.If(steps.ready & busy):
            m.d.sync += [kept.index.eq(index + 1), busy.eq(index != 3)]
        with m.If(given.valid & given.ready):
            m.d.sync += [busy.eq(1), kept.index.eq(0), *(kept[name].eq(value) for name, value in self._given.items())]
        latency = self.pipeline.latency
        m.d.sync += [self._wrong.eq(self.pipeline.moves(latency) & (self._first.value == 0) & ~self._there.value),
                     self._number.eq(self._shown.patch)]
        self.pipeline.add_to(m)
