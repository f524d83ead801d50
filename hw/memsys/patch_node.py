"""Patch node: holds a share of the patches for clusters."""

from amaranth.hdl import Module, ResetInserter
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.control_formats import ControlFormats
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.load.table_load import TableLoad
from hw.memsys.patches.local_patch_geometry import LocalPatchGeometry
from hw.memsys.patches.patch_type_memory import PatchTypeMemory
from hw.memsys.patches.path_formats import PathFormats

__all__ = ["PatchNode"]


class PatchNode(wiring.Component):
    """Answers the requests of clusters for patches that it holds, as a `Cluster` does beside its casts.

    ::

        i_word - TableLoad - tables
        i_remote - PatchTypeMemory - LocalPatchGeometry - o_remote

    A patch that it does not hold is answered with vertices of 0, which the cluster flags.

    Parameters
    ----------
    config
        The configuration; a machine has ``noc.patch_nodes`` patch nodes.

    Members
    -------
    number : In(PathFormats.cluster)
        The number of its node, which names it in residence tables. Stable after reset.
    reset : In(1)
        Resets everything but the tables.
    i_word : In, stream of `ControlFormats.load_word`
        Words of all nodes. Not during a cast.
    loads : Out(1)
        A word has not been stored yet.
    i_remote : In, stream of `PathFormats.remote_request`
        The network interface's ``o_request``.
    o_remote : Out, stream of `PathFormats.remote_reply`
        Its ``i_reply``.

    Timing
    ------
    Latency: ``2 + 4`` cycles to the first vertex, `PatchTypeMemory`'s and `LocalPatchGeometry`'s. One vertex per cycle,
    without a gap between patches; stalls with ``o_remote``, one cycle later.

    Golden counterpart: `golden.engine.schedule.resident_sets.spread_sets`. Source: Shen 1993, section 5.3.6.
    """

    def __init__(self, *, config: Config):
        path, control = PathFormats(config), ControlFormats(config)
        self._types, self._geometry = PatchTypeMemory(config=config), LocalPatchGeometry(config=config)
        self._tables = TableLoad(config=config)
        self.latency = self._types.latency + self._geometry.latency
        super().__init__({
            "number": In(path.cluster), "reset": In(1), "i_word": In(stream.Signature(control.load_word)),
            "loads": Out(1), "i_remote": In(stream.Signature(path.remote_request)),
            "o_remote": Out(stream.Signature(path.remote_reply))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.types, m.submodules.geometry, m.submodules.tables = types, geometry, tables = (
            self._types, self._geometry, self._tables)
        m.submodules.words = words = SkidBuffer(self.i_word.payload.shape())
        wiring.connect(m, wiring.flipped(self.i_word), words.i)
        word = words.o.payload
        m.d.comb += [
            self.loads.eq(words.o.valid | tables.o_types.valid | tables.o_geometry.valid), words.o.ready.eq(1),
            tables.i.valid.eq(words.o.valid & (word.is_all | (word.cluster == self.number))),
            tables.i.payload.eq(word.item), types.cluster.eq(self.number), geometry.cluster.eq(self.number)]
        wiring.connect(m, tables.o_types, types.i_load)
        wiring.connect(m, tables.o_geometry, geometry.i_load)
        wiring.connect(m, wiring.flipped(self.i_remote), types.i_remote)
        wiring.connect(m, types.o_remote, geometry.i_remote)
        # Requesters see a register of whether replies are taken, not the network.
        m.submodules.replies = replies = SkidBuffer(self.o_remote.payload.shape(), bypass=True)
        wiring.connect(m, geometry.o_remote, replies.i)
        wiring.connect(m, replies.o, wiring.flipped(self.o_remote))
        return ResetInserter(self.reset)(m)
