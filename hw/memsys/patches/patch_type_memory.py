"""Patch type memory: which cluster holds a patch."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.memory_map.layout import EVERY_CLUSTER, NONE
from hw.formats import Formats
from hw.lib.pipeline import Pipeline
from hw.lib.shared_port import share_port
from hw.memsys.patches.path_formats import PathFormats

__all__ = ["PatchTypeMemory"]


class PatchTypeMemory(wiring.Component):
    """Looks up the cluster and the local address of a patch, for this cluster and for the others.

    A patch whose local address is beyond every cluster's memory is held by none. Whether its cluster exists is checked
    when the record is loaded.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    cluster : In(PathFormats.cluster)
        The number of this cluster. Stable while records are loaded.
    i_load : In, stream of `PathFormats.type_load`
        Records in any order; `NONE` as a cluster: the patch is in main memory only; `EVERY_CLUSTER`: this one has a
        copy, as each other one. Always ready; not while patches are in flight. Other addresses are ignored.
    i : In, stream of a patch id
        Lookups of this cluster.
    o : Out, stream of `PathFormats.found_patch`
        Their results.
    i_remote : In, stream of `PathFormats.remote_request`
        Lookups of other clusters.
    o_remote : Out, stream of `PathFormats.remote_found`
        Their results.

    Timing
    ------
    Latency: ``2`` cycles, of a load too. One patch per cycle on each side; stalls with its output.

    Golden counterpart: `golden.engine.schedule.resident_sets.ResidentSets.residence`. Source: Shen 1993, section 5.3.6.
    """

    def __init__(self, *, config: Config):
        formats, icu = PathFormats(config), Formats(config)
        self._config = config
        super().__init__({
            "cluster": In(formats.cluster),
            "i_load": In(stream.Signature(formats.type_load, always_ready=True)),
            "i": In(stream.Signature(icu.patch)), "o": Out(stream.Signature(formats.found_patch)),
            "i_remote": In(stream.Signature(formats.remote_request)),
            "o_remote": Out(stream.Signature(formats.remote_found))})
        row = StructLayout({"is_held": 1, "cluster": formats.cluster, "address": formats.own_patch_bits, "wrong": 1})
        self._memory = Memory(shape=row, depth=1 << icu.patch.width, init=[], attrs={"no_rw_check": 1})
        self._ports = [self._memory.read_port() for _ in range(2)]
        self._pipelines = [
            self._pipeline(self._ports[0], self.i, self.i.payload, self.o, self.o.payload),
            self._pipeline(self._ports[1], self.i_remote, self.i_remote.payload.patch, self.o_remote,
                           self.o_remote.payload.found)]
        remote = self._pipelines[1]
        remote.output(self.o_remote.payload.node, remote.input(self.i_remote.payload.node))
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
        given, writes = self.i_load.payload, Signal()
        address, row = Signal(range(self._memory.depth), reset_less=True), Signal(self._memory.shape, reset_less=True)
        nowhere, copied, known, fits = Signal(), Signal(), Signal(), Signal()
        record = given.record
        m.d.comb += [nowhere.eq(record.cluster.as_signed() == NONE),
                     copied.eq(record.cluster.as_signed() == EVERY_CLUSTER),
                     known.eq(copied | (record.cluster < self._config.noc.nodes)),
                     fits.eq(record.address < self._config.memsys.own_patches)]
        m.d.sync += [
            writes.eq(self.i_load.valid & (given.address < self._memory.depth)), address.eq(given.address),
            row.is_held.eq(known & fits), row.cluster.eq(Mux(copied, self.cluster, record.cluster)),
            row.address.eq(record.address),
            # A negative address is none.
            row.wrong.eq(~nowhere & (~known | record.address[-1]))]
        share_port(self._ports[1], m, self._memory.write_port(), enable=writes, address=address, data=row)
        return m
