"""Row pieces: of each row of a stage the grid rays that lie in sector and window."""

from amaranth.hdl import Array, Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout, View
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats, GridTableKind
from hw.ctu.position_search import PositionSearch
from hw.ctu.row_arcs import RowArcs
from hw.lib.queue import Queue

__all__ = ["RowPieces"]

# The arcs that a row of the sector and the window can have, as pairs of which is the one that begins at position 0;
# what they have in common rises in this order.
PAIRS = ((1, 1), (0, 1), (1, 0), (0, 0))
# Pieces on their way out.
PIECES = 4


class RowPieces(wiring.Component):
    """What the arcs of the sector and those of the window have in common, as columns.

    The window's are the same in all rows of a stage, and the sector's mostly end between the same columns: what has
    just been found of a pair of arcs is kept, with the ends for which it is true, and searched for again when either
    end is none of them.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `CtuFormats.grid_stage`
        Stages.
    i_table : In, stream of `CtuFormats.grid_table_write`
        Table entries, of which ROW and COLUMN are used. Always ready; not during a frustum.
    o : Out, stream of `CtuFormats.grid_piece`
        The pieces of each row in the order of their columns, then the stage's ``last`` item.
    frustum : In, `Formats.frustum`
        Constant during a frustum.

    Timing
    ------
    Latency: ``3 * bits(columns) + 17`` cycles, ``columns`` the shell's. Without a search a piece takes four cycles, and
    a row one more; a search takes ``3 * bits(columns) + 4`` more. Stalls with ``o``.

    Golden counterpart: `golden.engine.ctu.sector`. Source: Shen 1993, section 5.3.4.3.
    """

    def __init__(self, *, config: Config):
        self._config, formats = config, CtuFormats(config)
        self._formats = formats
        super().__init__({
            "i": In(stream.Signature(formats.grid_stage)),
            "i_table": In(stream.Signature(formats.grid_table_write, always_ready=True)),
            "o": Out(stream.Signature(formats.grid_piece)), "frustum": In(formats.frustum)})

    def elaborate(self, platform):
        m = Module()
        formats = self._formats
        bound, side = formats.position_bound, formats.grid_side
        lowest = -(1 << bound.width - 1)
        m.submodules.arcs = arcs = RowArcs(config=self._config)
        m.submodules.search = search = PositionSearch(formats=formats, address=formats.grid_column_address)
        m.submodules.pieces = pieces = Queue(formats.grid_piece, depth=PIECES)
        wiring.connect(m, pieces.o, wiring.flipped(self.o))
        self._add_table(m, arcs, search)

        given = Signal(formats.grid_stage, reset_less=True)
        window = given.window
        # Rows whose arcs have not been requested, and rows that are not done.
        unrequested, left = Signal(side), Signal(side)
        next_row, row = Signal(formats.grid_row_address, reset_less=True), Signal(formats.grid_row_address,
                                                                                 reset_less=True)
        m.d.comb += [arcs.i.valid.eq(unrequested != 0), arcs.i.payload.eq(next_row)]
        with m.If(arcs.i.valid & arcs.i.ready):
            m.d.sync += [unrequested.eq(unrequested - 1), next_row.eq(next_row + 1)]

        number, factor, addend = self._add_number(m)

        # Pairs of arcs that are left in this row and the first of them; the intersection of the pair before, and where
        # it has been found to be.
        pairs, chosen, pair = Signal(len(PAIRS)), Signal(range(len(PAIRS))), Signal(range(len(PAIRS)))
        low, end = Signal(bound, reset_less=True), Signal(bound, reset_less=True)
        m.submodules.known = known = Memory(shape=search.o.payload.shape(), depth=len(PAIRS), init=[],
                                            attrs={"ram_style": "distributed"})
        keep, recall = known.write_port(), known.read_port(domain="comb")
        recalled = Signal(search.o.payload.shape(), reset_less=True)
        is_known, fits, some = Signal(len(PAIRS)), Signal(), Signal()
        # Where the piece begins and how long it is, whether it is there at all, and whether it is the row's last one.
        piece = Signal(StructLayout({"low": side, "count": side}), reset_less=True)
        gives, is_last = Signal(), Signal()
        # Which arc begins later, and of each pair which one ends first.
        sector, is_later, ends_first = arcs.o.payload, Signal(reset_less=True), Signal(len(PAIRS), reset_less=True)
        sector_over, window_over, sector_ends = (Array(values)[chosen] for values in (
            [of_sector for of_sector, _ in PAIRS], [of_window for _, of_window in PAIRS], list(ends_first)))

        def choose(left):
            """The first pair of those that are left in this row."""
            m.d.sync += [pairs.eq(left), is_last.eq(~left.any())]
            for index in reversed(range(len(PAIRS))):
                with m.If(left[index]):
                    m.d.sync += chosen.eq(index)

        def keep_piece(low, end):
            """What lies between two counts of rays."""
            m.d.sync += [gives.eq(low < end), piece.low.eq(low), piece.count.eq(end - low)]

        made = pieces.i.payload
        m.d.comb += [
            recall.addr.eq(chosen), keep.addr.eq(pair), keep.data.eq(search.o.payload),
            search.i.payload.first.eq(given.first_column),
            search.i.payload.count.eq(given.columns), search.i.payload.low.eq(low), search.i.payload.end.eq(end),
            made.stage.eq(given.stage), made.shell.eq(given.shell), made.row.eq(row)]

        with m.FSM():
            with m.State("stage"):
                m.d.comb += self.i.ready.eq(1)
                stage = self.i.payload
                m.d.sync += [given.eq(stage), is_known.eq(0), number.eq(stage.first_ray), factor.eq(stage.row_number),
                             addend.eq(stage.columns), row.eq(stage.row), next_row.eq(stage.row),
                             left.eq(stage.rows)]
                with m.If(self.i.valid):
                    m.d.sync += unrequested.eq(stage.rows)
                    m.next = "row"
            with m.State("row"):
                choose(Cat((sector.wraps | (of_sector == 0)) & (window.wraps | (of_window == 0))
                           for of_sector, of_window in PAIRS))
                m.d.sync += [is_later.eq(sector.low > window.low), ends_first.eq(Cat(
                    (sector.over if of_sector else sector.end) < (window.over if of_window else window.end)
                    for of_sector, of_window in PAIRS))]
                with m.If(left == 0):
                    m.next = "over"
                with m.Elif(arcs.o.valid & (factor == 0)):
                    m.next = "pair"
            with m.State("pair"):
                # An arc of what goes over begins at position 0, before any other one.
                m.d.sync += [
                    low.eq(Mux(sector_over & window_over, lowest, Mux(
                        ~sector_over & (window_over | is_later), sector.low, window.low))),
                    end.eq(Mux(sector_ends, Mux(sector_over, sector.over, sector.end),
                               Mux(window_over, window.over, window.end))),
                    pair.eq(chosen), recalled.eq(recall.data)]
                choose(Cat(one & pairs[:index].any() for index, one in enumerate(pairs)))
                m.next = "known"
            with m.State("known"):
                # The row's arcs are not looked at any more.
                m.d.comb += arcs.o.ready.eq(is_last)
                m.d.sync += [
                    fits.eq(is_known.bit_select(pair, 1) & Cat(
                        (value >= found.least) & (value <= found.most)
                        for value, found in ((low, recalled.low), (end, recalled.end))).all()),
                    some.eq(low < end)]
                m.next = "choose"
            with m.State("choose"):
                keep_piece(recalled.low["count"], recalled.end["count"])
                with m.If(some & ~fits):
                    m.d.comb += search.i.valid.eq(1)
                    m.next = "search"
                with m.Else():
                    m.next = "give"
                with m.If(~some):
                    m.d.sync += gives.eq(0)
            with m.State("search"):
                m.d.comb += [search.o.ready.eq(1), keep.en.eq(search.o.valid)]
                keep_piece(search.o.payload.low["count"], search.o.payload.end["count"])
                with m.If(search.o.valid):
                    m.d.sync += is_known.bit_select(pair, 1).eq(1)
                    m.next = "give"
            with m.State("give"):
                m.d.comb += [pieces.i.valid.eq(gives), made.ray.eq(number + piece.low),
                             made.column.eq(given.first_column + piece.low), made.count.eq(piece["count"])]
                with m.If(pieces.i.ready | ~gives):
                    m.next = "pair"
                    with m.If(is_last):
                        m.d.sync += [left.eq(left - 1), row.eq(row + 1), number.eq(number + given.columns)]
                        m.next = "row"
            with m.State("over"):
                m.d.comb += [pieces.i.valid.eq(1), made.count.eq(0), made.last.eq(~given.final),
                             made.final.eq(given.final)]
                with m.If(pieces.i.ready):
                    m.next = "stage"
        return m

    def _add_table(self, m, arcs, search):
        """Table entries to the blocks, and the frustum."""
        table = self.i_table
        record = View(self._formats.grid_column, table.payload.data[:self._formats.grid_column.size])
        m.d.comb += [
            arcs.frustum.eq(self.frustum), arcs.i_table.valid.eq(table.valid), arcs.i_table.payload.eq(table.payload),
            search.i_write.valid.eq(table.valid & (table.payload.kind == GridTableKind.COLUMN)),
            search.i_write.payload.address.eq(table.payload.index),
            search.i_write.payload.position.eq(record.position)]

    def _add_number(self, m):
        """The number of a row's first ray; in the stage's first row a product, computed bit by bit while ``factor`` is
        not 0.
        """
        number, factor, addend = (Signal(shape, name=name, reset_less=True) for name, shape in (
            ("number", self._formats.grid_number), ("factor", self._formats.grid_side),
            ("addend", self._formats.grid_number)))
        with m.If(factor != 0):
            m.d.sync += [factor.eq(factor >> 1), addend.eq(addend << 1)]
            with m.If(factor[0]):
                m.d.sync += number.eq(number + addend)
        return number, factor, addend
