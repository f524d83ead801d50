"""Ct ray generator: the grid rays that each subshell requests, shell by shell."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import GRID_GROUP, CtuFormats
from hw.ctu.row_pieces import RowPieces
from hw.ctu.stage_rows import StageRows
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["CtRayGenerator"]

# Stages whose rows are known and that wait for their columns.
STAGES = 2


class CtRayGenerator(wiring.Component):
    """`StageRows` and `RowPieces` in a row, and then groups of neighbours.

    A stage's rows are looked for while the rays of the one before it leave.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `CtuFormats.subshell_window`
        Subshells.
    i_table : In, stream of `CtuFormats.grid_table_write`
        Table entries. Always ready; not during a frustum.
    i_over : In, stream without payload
        A stage is over. Always ready.
    o : Out, stream of `CtuFormats.grid_request`
        Of each subshell the shells from 2 on; of each shell the grid rays in sector and window by row and column, up to
        `GRID_GROUP` of a row together, then its ``last`` item; behind the last subshell a ``final`` item.
    frustum : In, `Formats.frustum`
    last_shell : In(shell)
        The frustum, and the last shell of its grid rays; constant during a frustum.

    Timing
    ------
    Latency: ``3 * bits(rows) + 3 * bits(columns) + 30`` cycles from a subshell to its first ray, ``rows`` and
    ``columns`` the shell's. A group per cycle within a row; stalls with ``o``, a cycle later, and while too many stages
    are in flight.

    Golden counterpart: `golden.engine.ctu.sector`, `golden.engine.cast.cluster_casting.ClusterCasting.schedule`.
    Source: Shen 1993, section 5.3.4.3.
    """

    def __init__(self, *, config: Config):
        self._config, formats = config, CtuFormats(config)
        self._formats = formats
        super().__init__({
            "i": In(stream.Signature(formats.subshell_window)),
            "i_table": In(stream.Signature(formats.grid_table_write, always_ready=True)),
            "i_over": In(stream.Signature(0, always_ready=True)),
            "o": Out(stream.Signature(formats.grid_request)),
            "frustum": In(formats.frustum), "last_shell": In(formats.shell)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.rows, m.submodules.pieces = rows, pieces = (
            StageRows(config=self._config), RowPieces(config=self._config))
        m.submodules.stages = stages = Queue(self._formats.grid_stage, depth=STAGES)
        wiring.connect(m, wiring.flipped(self.i), rows.i)
        wiring.connect(m, rows.o, stages.i)
        wiring.connect(m, stages.o, pieces.i)
        m.d.comb += [rows.i_over.valid.eq(self.i_over.valid), rows.last_shell.eq(self.last_shell)]
        for block in (rows, pieces):
            m.d.comb += [block.frustum.eq(self.frustum), block.i_table.valid.eq(self.i_table.valid),
                         block.i_table.payload.eq(self.i_table.payload)]

        # The rays of a piece; ``more`` of them behind those that were shown last.
        m.submodules.skid = skid = SkidBuffer(self.o.payload.shape())
        wiring.connect(m, skid.o, wiring.flipped(self.o))
        piece, shown, last = pieces.o, skid.i, Signal.like(self.o.payload, reset_less=True)
        more, follows = Signal(piece.payload["count"].shape()), Signal()
        rays = Mux(follows, more, piece.payload["count"])
        is_more = rays > GRID_GROUP
        m.d.comb += [
            shown.valid.eq(piece.valid | follows), piece.ready.eq(shown.ready & ~follows),
            *(shown.payload[name].eq(piece.payload[name]) for name in shown.payload.shape().members)]
        with m.If(follows):
            m.d.comb += [shown.payload.eq(last), shown.payload.ray.eq(last.ray + GRID_GROUP),
                         shown.payload.column.eq(last.column + GRID_GROUP)]
        m.d.comb += shown.payload["count"].eq(Mux(is_more, GRID_GROUP, rays))
        with m.If(shown.ready):
            m.d.sync += [last.eq(shown.payload), more.eq(rays - GRID_GROUP), follows.eq(shown.valid & is_more)]
        return m
