"""Patch type memory: where each patch is held."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.pipeline import Pipeline
from hw.lib.shared_port import share_port
from hw.memsys.path_formats import PathFormats

__all__ = ["PatchTypeMemory"]


class PatchTypeMemory(wiring.Component):
    """Finds the cluster and the local address of a patch, for this cluster and for others that ask it.

    A patch whose local address is beyond every cluster's memory is held by none. Whether there is such a cluster is
    found out when the record is loaded.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load
        `PathFormats.type_load`, in any order; -1 as a cluster: the patch is in main memory only. Always ready; not
        while patches are under way. Addresses that there are not here are ignored.
    i, o
        Patch ids, and `PathFormats.found_patch`.
    i_asked, o_asked
        ``node`` that asks, and ``patch``; ``node`` and ``place``, a `PathFormats.found_patch`.

    Timing
    ------
    Latency: ``2`` cycles, of a load too. One patch per cycle on each side; stalls with its output.

    Golden counterpart: `golden.schedule.resident_sets.ResidentSets.residence`. Source: Shen 1993, section 5.3.6.
    """

    def __init__(self, *, config: Config):
        formats, icu = PathFormats(config), Formats(config)
        self._config, self._formats = config, formats
        node = config.noc.node_bits
        super().__init__({
            "i_load": In(stream.Signature(formats.type_load, always_ready=True)),
            "i": In(stream.Signature(icu.patch)), "o": Out(stream.Signature(formats.found_patch)),
            "i_asked": In(stream.Signature(StructLayout({"node": node, "patch": icu.patch}))),
            "o_asked": Out(stream.Signature(StructLayout({"node": node, "place": formats.found_patch})))})
        row = StructLayout({"is_held": 1, "cluster": formats.cluster, "address": formats.place_bits, "wrong": 1})
        self._memory = Memory(shape=row, depth=1 << icu.patch.width, init=[], attrs={"no_rw_check": 1})
        self._ports = [self._memory.read_port() for _ in range(2)]
        self._pipelines = [
            self._pipeline(self._ports[0], self.i, self.i.payload, self.o, self.o.payload),
            self._pipeline(self._ports[1], self.i_asked, self.i_asked.payload.patch, self.o_asked,
                           self.o_asked.payload.place)]
        asked = self._pipelines[1]
        asked.output(self.o_asked.payload.node, asked.input(self.i_asked.payload.node))
        self.latency = self._pipelines[0].latency

    def _pipeline(self, port, i, patch, o, found):
        pipeline = Pipeline(i, o)
        patch = pipeline.input(patch)
        row = pipeline.delay(pipeline.read(port, patch), 1)
        pipeline.output(found.patch, patch)
        for name in "is_held", "cluster", "address", "wrong":
            pipeline.output(found[name], pipeline.combine(lambda row, name=name: row[name], row))
        return pipeline

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        for pipeline in self._pipelines:
            pipeline.add_to(m)
        given, comes = self.i_load.payload, Signal()
        address, row = Signal(range(self._memory.depth), reset_less=True), Signal(self._memory.shape, reset_less=True)
        nowhere, known, fits = Signal(), Signal(), Signal()
        record = given.record
        m.d.comb += [nowhere.eq(record.cluster.all()), known.eq(record.cluster < self._config.noc.nodes),
                     fits.eq(record.address < self._config.memsys.own_patches)]
        m.d.sync += [
            comes.eq(self.i_load.valid & (given.address < self._memory.depth)), address.eq(given.address),
            row.is_held.eq(known & fits), row.cluster.eq(record.cluster), row.address.eq(record.address),
            # A negative address is none.
            row.wrong.eq(~nowhere & (~known | record.address[-1]))]
        share_port(self._ports[1], m, self._memory.write_port(), enable=comes, address=address, data=row)
        return m
