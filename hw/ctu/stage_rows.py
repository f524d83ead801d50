"""Stage rows: the shells of each subshell one after the other, and their rows of grid rays in sector and window."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout, View
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.ctu.grid_rays import INDEX_FRACTION
from hw.ctu.ctu_formats import CtuFormats, GridTableKind
from hw.ctu.position_search import PositionSearch
from hw.lib.checks import count_steps

__all__ = ["StageRows"]

# The first shell that has grid rays.
FIRST = 2


class StageRows(wiring.Component):
    """Rows whose position is in the window and not more than ``row_border`` outside the sector.

    A stage begins while at most ``run_ahead`` stages before it are in flight; with ``subshell_barrier`` the first stage
    of a subshell begins when none is.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `CtuFormats.subshell_window`
        Subshells.
    i_table : In, stream of `CtuFormats.grid_table_write`
        Table entries, of which SHELL and the positions of ROW are used. Always ready; not during a frustum.
    i_over : In, stream without payload
        A stage is over. Always ready.
    o : Out, stream of `CtuFormats.grid_stage`
        The stages of each subshell, in which ``rows`` may be 0; behind the last one a ``final`` item.
    frustum : In, `Formats.frustum`
    last_shell : In(shell)
        The frustum, and the last shell of its grid rays; constant during a frustum.

    Timing
    ------
    Latency: ``3 * bits(rows) + 11`` cycles from a subshell to its first stage, ``rows`` the shell's, and one less from
    there to the next one. One stage at a time; stalls with ``o`` and while too many are in flight.

    Golden counterpart: `golden.engine.ctu.sector`, `golden.engine.cast.cluster_casting.ClusterCasting.schedule`.
    Source: Shen 1993, section 5.3.4.2.
    """

    def __init__(self, *, config: Config):
        formats = self._formats = CtuFormats(config)
        self._run_ahead, self._barrier = config.ctu.run_ahead, config.ctu.subshell_barrier
        super().__init__({
            "i": In(stream.Signature(formats.subshell_window)),
            "i_table": In(stream.Signature(formats.grid_table_write, always_ready=True)),
            "i_over": In(stream.Signature(0, always_ready=True)),
            "o": Out(stream.Signature(formats.grid_stage)),
            "frustum": In(formats.frustum), "last_shell": In(formats.shell)})

    def elaborate(self, platform):
        m = Module()
        formats, bound = self._formats, self._formats.position_bound
        lowest, highest = -(1 << bound.width - 1), (1 << bound.width - 1) - 1
        m.submodules.search = search = PositionSearch(formats=formats, address=formats.grid_row_address)
        read = self._add_tables(m, search)

        def whole(index):
            """The position at which a row or column of rays begins."""
            return index << INDEX_FRACTION

        frustum, section = self.frustum, self.frustum.section
        around = whole(frustum.columns)
        given, shell, stage = Signal(self.i.payload.shape(), reset_less=True), Signal(formats.shell.width + 1), Signal(
            formats.stage)
        window, low, end = Signal(formats.arcs, reset_less=True), Signal(bound, reset_less=True), Signal(
            bound, reset_less=True)
        sector_low, sector_end = Signal(bound, reset_less=True), Signal(bound, reset_less=True)
        record = Signal.like(read.data, reset_less=True)
        in_flight, starts = Signal(range((1 << formats.stage.width) + 1)), Signal()
        count_steps(m, in_flight, up=starts, down=self.i_over.valid, most=1 << formats.stage.width)
        m.d.sync += starts.eq(0)
        # The stage that is given has started: the next one's numbers.
        with m.If(starts):
            m.d.sync += [stage.eq(stage + 1), shell.eq(shell + 1)]
        window_end = whole(given.window.column_first + given.window.column_count)
        m.d.comb += read.addr.eq(shell)
        stage_over = self.o.ready & self.o.valid

        with m.FSM():
            with m.State("subshell"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += [given.eq(self.i.payload), shell.eq(FIRST)]
                with m.If(self.i.valid & (self.i.payload.last | (
                        (self.i.payload.window.row_count != 0) & (self.i.payload.window.column_count != 0)))):
                    m.next = "window"
            with m.State("window"):
                m.d.sync += [
                    window.low.eq(whole(given.window.column_first)), window.end.eq(window_end), window.wraps.eq(0),
                    window.over.eq(window_end - around),
                    low.eq(whole(given.window.row_first)),
                    end.eq(whole(given.window.row_first + given.window.row_count))]
                with m.If(given.last):
                    m.d.sync += [edge.eq(value) for edge, value in (
                        (window.low, lowest), (window.end, highest), (low, lowest), (end, highest))]
                with m.Elif(~frustum.is_screen & (window_end > around)):
                    m.d.sync += [window.wraps.eq(1), window.end.eq(highest)]
                m.next = "stage"
            with m.State("stage"):
                with m.If((shell > self.last_shell) | (~given.last & (shell > given.shell))):
                    m.next = "subshell"
                    with m.If(given.last):
                        m.next = "final"
                with m.Elif((in_flight == 0) | (in_flight <= self._run_ahead) & (
                        (shell != FIRST) if self._barrier else 1)):
                    m.next = "record"
            with m.State("record"):
                m.d.sync += record.eq(read.data)
                m.next = "sector"
            with m.State("sector"):
                m.d.sync += [sector_low.eq(whole(section.first_row) - record.row_border),
                             sector_end.eq(whole(section.end_row) + record.row_border + 1)]
                m.next = "both"
            with m.State("both"):
                m.d.sync += [sector_low.eq(Mux(sector_low < low, low, sector_low)),
                             sector_end.eq(Mux(sector_end < end, sector_end, end))]
                m.next = "search"
            with m.State("search"):
                m.d.comb += search.i.valid.eq(1)
                with m.If(search.i.ready):
                    m.next = "rows"
            with m.State("rows"):
                m.d.comb += search.o.ready.eq(1)
                low_row, end_row = search.o.payload.low["count"], search.o.payload.end["count"]
                m.d.sync += [
                    self.o.payload.row.eq(record.first_row + low_row), self.o.payload.row_number.eq(low_row),
                    self.o.payload.rows.eq(Mux(end_row > low_row, end_row - low_row, 0)),
                    self.o.payload.stage.eq(stage), self.o.payload.shell.eq(shell), self.o.payload.window.eq(window),
                    self.o.payload.final.eq(0),
                    *(self.o.payload[name].eq(record[name]) for name in ("first_column", "columns", "first_ray"))]
                with m.If(search.o.valid):
                    m.d.sync += starts.eq(1)
                    m.next = "give"
            with m.State("give"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(stage_over):
                    m.next = "stage"
            with m.State("final"):
                m.d.sync += [stage.eq(0), self.o.payload.rows.eq(0), self.o.payload.final.eq(1)]
                m.next = "end"
            with m.State("end"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(stage_over):
                    m.next = "subshell"
        m.d.comb += [search.i.payload.first.eq(record.first_row), search.i.payload.count.eq(record.rows),
                     search.i.payload.low.eq(sector_low), search.i.payload.end.eq(sector_end)]
        return m

    def _add_tables(self, m, search):
        """Positions of rows to the search, and the table of the shells, whose read port it returns."""
        formats, table = self._formats, self.i_table
        kept = StructLayout({name: formats.grid_shell[name].shape for name in (
            "row_border", "first_row", "rows", "first_column", "columns", "first_ray")})
        m.submodules.shells = shells = Memory(shape=kept, depth=1 << formats.shell.width, init=[])
        write, read = shells.write_port(), shells.read_port()
        shell_record, row_record = (View(record, table.payload.data[:record.size])
                                    for record in (formats.grid_shell, formats.grid_row))
        m.d.comb += [
            write.addr.eq(table.payload.index), write.en.eq(table.valid & (table.payload.kind == GridTableKind.SHELL)),
            *(write.data[name].eq(shell_record[name]) for name, _ in kept),
            search.i_write.valid.eq(table.valid & (table.payload.kind == GridTableKind.ROW)),
            search.i_write.payload.address.eq(table.payload.index),
            search.i_write.payload.position.eq(row_record.position)]
        return read
