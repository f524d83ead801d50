"""Local patch geometry: the vertices of a cluster's resident set."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import Formats
from hw.lib.pipeline import Pipeline
from hw.lib.shared_port import share_port
from hw.memsys.bus.patch_decoder import PatchDecoder
from hw.memsys.patches.path_formats import PathFormats

__all__ = ["LocalPatchGeometry"]


class LocalPatchGeometry(wiring.Component):
    """Reads patches by local address, for this cluster and for the others: the four vertices of a patch, one after the
    other.

    A patch that is not there is read as four vertices of 0, which no ray hits. Of this cluster's reads it is flagged;
    other readers find it with `VoidCheck`.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load : In, stream of `PathFormats.geometry_load`
        The first six words of each patch in their order. Always ready; not while patches are in flight. Other addresses
        are ignored.
    i : In, stream of ``patch``, ``address``
        Reads of this cluster.
    o : Out, stream of `Formats.patch_vertex`
        Their vertices.
    i_remote : In, stream of `PathFormats.remote_found`
        Reads of other clusters. A patch that this cluster does not hold is not there.
    o_remote : Out, stream of `PathFormats.remote_reply`
        Their vertices.
    cluster : In(PathFormats.cluster)
        The number of this cluster. Stable while patches are in flight.
    wrong : Out(1)
        A patch of ``i`` is not there; in the cycle after its first vertex has left.
    number : Out(patch_bits)
        That patch.

    Timing
    ------
    Latency: ``4`` cycles to the first vertex. One vertex per cycle on each side, without a gap between patches; stalls
    with its output.

    Source: Shen 1993, section 5.3.6.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats, self._icu = config, PathFormats(config), Formats(config)
        formats, icu = self._formats, self._icu
        super().__init__({
            "i_load": In(stream.Signature(formats.geometry_load, always_ready=True)),
            "i": In(stream.Signature(StructLayout({"patch": icu.patch, "address": formats.own_patch_bits}))),
            "o": Out(stream.Signature(icu.patch_vertex)),
            "i_remote": In(stream.Signature(formats.remote_found)),
            "o_remote": Out(stream.Signature(formats.remote_reply)),
            "cluster": In(formats.cluster), "wrong": Out(1), "number": Out(icu.patch)})
        patches = config.memsys.own_patches
        self._vertices = Memory(shape=icu.scene_vector, depth=4 * patches, init=[], attrs={"no_rw_check": 1})
        self._heads = Memory(shape=formats.patch_head, depth=patches, init=[], attrs={"no_rw_check": 1})
        own, remote = self.i.payload, self.i_remote.payload
        found = remote.found
        self._sides = [
            _Side(self, i=self.i, o=self.o, vertex=self.o.payload, wrong=self.wrong,
                  request={"patch": own.patch, "address": own.address, "present": 1}),
            _Side(self, i=self.i_remote, o=self.o_remote, vertex=self.o_remote.payload.vertex,
                  request={"patch": found.patch, "address": found.address, "node": remote.node,
                           "present": found.is_held & ~found.wrong & (found.cluster == self.cluster)},
                  node=self.o_remote.payload.node)]
        self.latency = 1 + self._sides[0].pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.vertices, m.submodules.heads = self._vertices, self._heads
        for side in self._sides:
            side.add_to(m)
        m.d.sync += self.number.eq(self.o.payload.patch)
        self._add_load(m)
        return m

    def _add_load(self, m):
        """Heads, and vertices as they are decoded."""
        given, address_bits = self.i_load.payload, self._formats.own_patch_bits
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
    """One read port: a pipeline, and the sequence of the four vertices of a patch.

    Parameters
    ----------
    of
        The component.
    i, o
        Its streams.
    vertex, node
        Parts of the payload of ``o``.
    wrong
        A port: a patch is not there; none of the others' reads.
    request
        ``patch``, ``address``, ``present``, and ``node`` if there is one, from the payload of ``i``.
    """

    def __init__(self, of, *, i, o, vertex, request, wrong=None, node=None):
        self._i, self._wrong, self._request = i, wrong, request
        formats, icu = of._formats, of._icu
        shape = {"patch": icu.patch, "address": formats.own_patch_bits, "present": 1}
        if node is not None:
            shape["node"] = node.shape()
        self._steps = stream.Signature(StructLayout({"index": 2, **shape})).create()
        self.pipeline = pipeline = Pipeline(self._steps, o)
        step = {name: pipeline.input(self._steps.payload[name]) for name in ("index", *shape)}
        beat = pipeline.combine(lambda index, address: Cat(index, address), step["index"], step["address"])
        self.vertices, self.heads = of._vertices.read_port(), of._heads.read_port()
        read = pipeline.delay(pipeline.read(self.vertices, beat), 1)
        head = pipeline.delay(pipeline.read(self.heads, step["address"]), 1)
        present = pipeline.register(lambda present, head, patch: present & (head.patch == patch), step["present"], head,
                                    step["patch"])
        pipeline.output(vertex.patch, step["patch"])
        pipeline.output(vertex.surface, pipeline.combine(lambda head: head.surface, head))
        for axis in range(3):
            pipeline.output(vertex.vertex[axis], pipeline.combine(
                lambda read, present, axis=axis: read[axis] & present.replicate(len(read[axis])), read, present))
        if node is not None:
            pipeline.output(node, step["node"])
        self._index, self._present = pipeline.align(step["index"], present)

    def add_to(self, m):
        """Add the sequence and the pipeline to the component's module."""
        steps, given = self._steps, self._i
        busy, kept, index = Signal(), Signal.like(steps.payload, reset_less=True), steps.payload.index
        m.d.comb += [steps.valid.eq(busy), steps.payload.eq(kept),
                     given.ready.eq(~busy | (steps.ready & (index == 3)))]
        with m.If(~busy | steps.ready):
            with m.If(~busy | (index == 3)):
                m.d.sync += [busy.eq(given.valid), kept.index.eq(0),
                             *(kept[name].eq(value) for name, value in self._request.items())]
            with m.Else():
                m.d.sync += kept.index.eq(index + 1)
        if self._wrong is not None:
            m.d.sync += self._wrong.eq(
                self.pipeline.moves(self.pipeline.latency) & (self._index.value == 0) & ~self._present.value)
        self.pipeline.add_to(m)
