"""Traversal unit: from a frustum and a list of subshells to cells."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ct_ray_generator import CtRayGenerator
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.ray_traversal import RayTraversal
from hw.ctu.subshell_generator import SubshellGenerator
from hw.ctu.subshell_windows import SubshellWindows

__all__ = ["TraversalUnit"]


class TraversalUnit(wiring.Component):
    """The Cell Traversal Unit of one cluster.

    ::

        i_frustum - SubshellGenerator - SubshellWindows - CtRayGenerator - RayTraversal - o
                            |                  |                 '--------- o_over ---'
                     o_entry, i_entry   o_patch, i_vertex

    A frustum: write its tables, give its numbers, send the near cells. It is over with the final item.

    Parameters
    ----------
    config
        The configuration. Where there are no lists (``ctu.subshell_bits`` of 0) there is no `SubshellWindows`, and none
        of the streams ``i_slack``, ``o_entry``, ``i_entry``, ``o_patch`` and ``i_vertex``.
    pipelines
        Traversal pipelines, see `golden.engine.config.Ctu.traversal_pipelines`.

    Members
    -------
    i_frustum : In, stream of ``traversal``, ``last_shell``, ``subshells``
        A frustum (`CtuFormats.traversal_frustum`) and its list (`SubshellGenerator`, ``i``). Accepted when the one
        before is over. The intersection unit has begun the frustum before.
    i_table : In, stream of `CtuFormats.grid_table_write`
    i_slack : In, stream of `IcuFormats.table_write`
        Table entries; of the second stream SLACK is used. Always ready; not during a frustum.
    i_near : In, stream of `CtuFormats.near_cell`
        The cells of shell 1.
    o_entry : Out, stream of addresses; i_entry : In, stream of ``patch``, ``shell``
        See `SubshellGenerator`, ``o_read`` and ``i_read``.
    o_patch : Out, stream of patches; i_vertex : In, stream of `Formats.patch_vertex`
        See `SubshellWindows`.
    o : Out, stream of `CtuFormats.met_cell`
        Cells.
    closed : Out(1); settled : In(1); o_tile : Out, stream; i_word : In, stream; counters : Out, struct
        See `RayTraversal`.
    error : Out, `ListError`
        See `SubshellGenerator`.

    Timing
    ------
    See the blocks. At most ``run_ahead`` + 1 stages are in flight.

    Golden counterpart: `golden.engine.ctu.unit.CellTraversalUnit`, `golden.engine.cast.cluster_casting.ClusterCasting`.
    Source: Shen 1993, section 5.3.4.
    """

    def __init__(self, *, config: Config, pipelines: int = 1):
        formats = CtuFormats(config)
        self._back = RayTraversal(config=config, pipelines=pipelines)
        self._subshells = SubshellGenerator(config=config)
        self._windows = SubshellWindows(config=config) if config.ctu.subshells else None
        self._rays = CtRayGenerator(config=config)
        self._given = StructLayout({
            "traversal": formats.traversal_frustum, "last_shell": formats.shell,
            "subshells": self._subshells.i.payload.shape()})
        # Streams that go straight through, by the name inside.
        self._straight = [(self._back, {"i_near": "i_near", "o": "o", "o_tile": "o_tile", "i_word": "i_word"})]
        if self._windows:
            self._straight += [
                (self._subshells, {"o_entry": "o_read", "i_entry": "i_read"}),
                (self._windows, {"o_patch": "o_patch", "i_vertex": "i_vertex", "i_slack": "i_table"})]
        members = {}
        for block, names in self._straight:
            for outer, inner in names.items():
                members[outer] = block.signature.members[inner]
        super().__init__({
            "i_frustum": In(stream.Signature(self._given)),
            "i_table": In(stream.Signature(formats.grid_table_write, always_ready=True)), **members,
            "closed": Out(1), "settled": In(self._back.settled.shape()), "error": Out(self._subshells.error.shape()),
            "counters": Out(self._back.counters.shape())})

    def elaborate(self, platform):
        m = Module()
        m.submodules.subshells, m.submodules.rays = subshells, rays = self._subshells, self._rays
        m.submodules.back = back = self._back
        for block, names in self._straight:
            for outer, inner in names.items():
                wiring.connect(m, wiring.flipped(getattr(self, outer)), getattr(block, inner))

        # A frustum is kept, and then all begin it.
        kept, runs = Signal(self._given), Signal()
        waits = {block: Signal(name=f"waits_{name}") for name, block in (("subshells", subshells), ("back", back))}
        given = self.i_frustum
        m.d.comb += given.ready.eq(~runs)
        starts = {subshells: subshells.i, back: back.i_frustum}
        with m.If(given.valid & given.ready):
            m.d.sync += [kept.eq(given.payload), runs.eq(1), *(wait.eq(1) for wait in waits.values())]
        for block, start in starts.items():
            m.d.comb += start.valid.eq(waits[block])
            with m.If(start.valid & start.ready):
                m.d.sync += waits[block].eq(0)
        with m.If(self.o.valid & self.o.ready & self.o.payload.final):
            m.d.sync += runs.eq(0)
        frustum = kept.traversal.frustum
        m.d.comb += [
            subshells.i.payload.eq(kept.subshells), back.i_frustum.payload.eq(kept.traversal),
            rays.frustum.eq(frustum), rays.last_shell.eq(kept.last_shell)]

        if self._windows:
            m.submodules.windows = windows = self._windows
            m.d.comb += windows.frustum.eq(frustum)
            wiring.connect(m, subshells.o, windows.i)
            wiring.connect(m, windows.o, rays.i)
        else:
            # There is only the last one, whose window is not used.
            m.d.comb += [rays.i.valid.eq(subshells.o.valid), subshells.o.ready.eq(rays.i.ready),
                         rays.i.payload.shell.eq(subshells.o.payload.shell),
                         rays.i.payload.last.eq(subshells.o.payload.last)]
        wiring.connect(m, rays.o, back.i)
        m.d.comb += [rays.i_over.valid.eq(back.o_over.valid), back.settled.eq(self.settled),
                     self.closed.eq(back.closed),
                     self.error.eq(subshells.error), self.counters.eq(back.counters)]
        for block in rays, back:
            m.d.comb += [block.i_table.valid.eq(self.i_table.valid), block.i_table.payload.eq(self.i_table.payload)]
        return m
