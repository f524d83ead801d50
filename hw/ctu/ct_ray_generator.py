"""Ct ray generator: the grid rays that each subshell requests, shell by shell."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.ctu.ctu_formats import GRID_GROUP, CtuFormats
from hw.ctu.row_pieces import RowPieces
from hw.ctu.stage_rows import StageRows
from hw.lib.queue import Queue

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
    Latency: ``3 * bits(rows) + 3 * bits(columns) + 28`` cycles from a subshell to its first ray, ``rows`` and
    ``columns`` the shell's. A group per cycle within a row; stalls with ``o`` and while too many stages are in flight.

    Golden counterpart: `golden.ctu.sector`, `golden.cast.cluster_casting.ClusterCasting.schedule`. Source: Shen 1993,
    section 5.3.4.3.
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

        # The rays of a piece; ``more`` of them behind those that are shown.
        piece, shown = pieces.o, self.o
        more = Signal(piece.payload["count"].shape())
        follows = more != 0
        leaves = shown.ready | ~shown.valid

        def first_of(rays):
            return Mux(rays > GRID_GROUP, GRID_GROUP, rays)

        m.d.comb += piece.ready.eq(leaves & ~follows)
        with m.If(leaves):
            with m.If(follows & shown.valid):
                m.d.sync += [more.eq(more - first_of(more)), shown.payload["count"].eq(first_of(more)),
                             shown.payload.ray.eq(shown.payload.ray + GRID_GROUP),
                             shown.payload.column.eq(shown.payload.column + GRID_GROUP)]
            with m.Else():
                rays = piece.payload["count"]
                m.d.sync += [
                    shown.valid.eq(piece.valid), more.eq(Mux(piece.valid, rays - first_of(rays), 0)),
                    shown.payload["count"].eq(first_of(rays)),
                    *(shown.payload[name].eq(piece.payload[name])
                      for name in ("stage", "shell", "ray", "row", "column", "last", "final"))]
        return m
