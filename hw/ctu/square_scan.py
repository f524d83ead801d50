"""Square scan: is a square of a window live?"""

from itertools import pairwise

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import Formats

__all__ = ["SIDE_BITS", "SquareScan", "extent", "square"]

# A word holds 2^b x 2^b squares, and a square of a level as many of the level below.
SIDE_BITS = 2
# Registers that a window passes for each word: it enters, its word is addressed, read, held, compared and decided.
STAGES = 6


def square_bits(config: Config, level: int) -> int:
    """A square of a level has 2^b x 2^b rays."""
    return config.icu.tile_bits + SIDE_BITS * level


def square(config: Config, level: int) -> StructLayout:
    """The smallest code of a square, and which of the section's it is."""
    side = max(SIDE_BITS + 1, config.icu.side_bits - square_bits(config, level))
    return StructLayout({"column": side, "row": side, "code": Formats(config).settle})


def extent(config: Config) -> StructLayout:
    """First and last columns and rows of a section's window, if it has ``some``, and the last of the columns that go
    ``round`` to column 0.
    """
    return StructLayout({"some": 1, "round": 1, **dict.fromkeys(
        ("column_first", "column_last", "wrapped_last", "row_first", "row_last"), Formats(config).index)})


def words(config: Config, level: int) -> int:
    """Words of the largest section: any one whose tiles the settle map can hold."""
    icu, side = config.icu, 1 << SIDE_BITS * (level + 1)
    tiles, across = icu.rays >> 2 * icu.tile_bits, 1 << icu.side_bits - icu.tile_bits
    # At least two: a memory of a single word has no address.
    return max(2, *(-(-min(across, tiles // columns) // side) << (-(-columns // side) - 1).bit_length()
                    for columns in range(1, min(across, tiles) + 1)))


class SquareScan(wiring.Component):
    """``live``: a square that the window touches has a code below the threshold.

    Windows go round a ring of registers, a word of 4 x 4 squares in each round, and leave it with the first live square
    or after the last word. So they may overtake each other.

    Parameters
    ----------
    config
        The configuration.
    level
        Of the squares, 0 for the settle map's tiles.
    tag
        Shape of the sideband.

    Members
    -------
    i : In, stream of ``tag``, ``threshold``, ``extent``
        Windows (`extent`).
    o : Out, stream of ``tag``, ``threshold``, ``extent``, ``live``
        The same, and whether a square is live.
    i_square : In, stream of `square`
        The smallest code of a square of the section. Always ready.
    fresh : In(1)
        All squares have been written in this frustum; until then all are live.
    columns : In(count)
        The section's; constant while windows are in flight.

    Timing
    ------
    Latency: ``6`` cycles to the first word, 6 for each further one. One word per cycle, of any window; stalls while a
    window waits to leave. A code is seen 2 cycles after it came, or 1.

    Golden counterpart: `golden.engine.ctu.survival.survivors_by_code`.
    """

    def __init__(self, *, config: Config, level: int, tag):
        self._config, self._level, self._formats = config, level, Formats(config)
        formats = self._formats
        item = {"tag": tag, "threshold": formats.threshold, "extent": extent(config)}
        self._word_bits = max(1, config.icu.side_bits - square_bits(config, level) - SIDE_BITS)
        self._item = StructLayout({**item, "column": self._word_bits, "row": self._word_bits, "second": 1})
        super().__init__({
            "i": In(stream.Signature(StructLayout(item))),
            "o": Out(stream.Signature(StructLayout({**item, "live": 1}))),
            "i_square": In(stream.Signature(square(config, level), always_ready=True)),
            "fresh": In(1), "columns": In(formats.count)})
        self.latency = STAGES

    def elaborate(self, platform):
        m = Module()
        bits, side = square_bits(self._config, self._level), 1 << SIDE_BITS
        lanes, word = side * side, self._word
        read, address = self._add_squares(m)

        def lane(value):
            return Cat(value, Const(0, 16))[bits:bits + SIDE_BITS]

        moves, ends, done = Signal(), Signal(), Signal()
        valid = [Signal(name=f"valid_{stage}") for stage in range(STAGES)]
        rays = [Signal(self._item, name=f"window_{stage}", reset_less=True) for stage in range(STAGES)]
        entered, addressed, fetched, held, compared, decided = rays

        # Which squares of the word lie in the window, and where the walk continues.
        near = addressed.extent
        first = Mux(addressed.second, 0, near.column_first)
        last = Mux(addressed.second, near.wrapped_last, near.column_last)
        last_column, last_row = Signal(reset_less=True), Signal(reset_less=True)
        columns, rows = Signal(side, reset_less=True), Signal(side, reset_less=True)
        is_fresh, was_fresh, still_fresh = (Signal(reset_less=True, name=name)
                                            for name in ("is_fresh", "was_fresh", "still_fresh"))
        inside, codes, below, over = (Signal(lanes, reset_less=True), Signal.like(read.data, reset_less=True),
                                      Signal(lanes, reset_less=True), Signal(reset_less=True))
        ended = Signal(reset_less=True)
        # What all registers of the ring depend on is known before.
        found, live, finishes = Signal(), Signal(reset_less=True), Signal(reset_less=True)

        def lies(at, first, last):
            """Of a word's columns or rows those between two of the section's, both among them."""
            return Cat(((at != word(first)) | (k >= lane(first))) & ((at != word(last)) | (k <= lane(last)))
                       for k in range(side))

        m.d.comb += [
            found.eq(compared.extent.some & (below.any() | ~still_fresh)), done.eq(valid[-1] & finishes),
            moves.eq(self.o.ready | ~done), self.o.valid.eq(done), self.o.payload.live.eq(live),
            self.i.ready.eq(moves & ~(valid[-1] & ~done)),
            *(self.o.payload[name].eq(decided[name]) for name in ("tag", "threshold", "extent")),
            read.en.eq(moves), ends.eq(~fetched.extent.some | (
                last_column & last_row & (fetched.second | ~fetched.extent.round)))]
        enters = self.i.payload
        with m.If(moves):
            for source, target in pairwise(range(STAGES)):
                m.d.sync += [valid[target].eq(valid[source]), rays[target].eq(rays[source])]
            m.d.sync += [
                valid[0].eq(self.i.valid | (valid[-1] & ~done)), rays[0].eq(decided),
                # Of the word: addressed, ...
                read.addr.eq(address(entered.column, entered.row)),
                # ... being read, ...
                columns.eq(lies(addressed.column, first, last)),
                rows.eq(lies(addressed.row, near.row_first, near.row_last)),
                last_column.eq(addressed.column == word(last)), last_row.eq(addressed.row == word(near.row_last)),
                is_fresh.eq(self.fresh),
                # ... held, ...
                codes.eq(read.data), inside.eq(Cat(columns & rows[k].replicate(side) for k in range(side))),
                ended.eq(ends), was_fresh.eq(is_fresh),
                # ... compared, ...
                below.eq(Cat((codes[k] < held.threshold) & inside[k] for k in range(lanes))), over.eq(ended),
                still_fresh.eq(was_fresh),
                # ... and decided.
                live.eq(found), finishes.eq(found | over)]
            with m.If(~(valid[-1] & ~done)):
                m.d.sync += [entered.tag.eq(enters.tag), entered.threshold.eq(enters.threshold),
                             entered.extent.eq(enters.extent), entered.second.eq(0),
                             entered.column.eq(word(enters.extent.column_first)),
                             entered.row.eq(word(enters.extent.row_first))]
            # To the next word: of the row, of the piece that wraps, of the next row.
            with m.If(~last_column):
                m.d.sync += held.column.eq(fetched.column + 1)
            with m.Elif(fetched.extent.round & ~fetched.second):
                m.d.sync += [held.column.eq(0), held.second.eq(1)]
            with m.Else():
                m.d.sync += [held.column.eq(word(fetched.extent.column_first)), held.second.eq(0),
                             held.row.eq(fetched.row + 1)]
        return m

    def _word(self, value):
        """The word of a column or a row of rays."""
        return Cat(value, Const(0, 16))[square_bits(self._config, self._level) + SIDE_BITS:][:self._word_bits]

    def _add_squares(self, m):
        """The memory of the codes: its read port, and the address of a word."""
        lanes = 1 << 2 * SIDE_BITS
        m.submodules.memory = memory = Memory(shape=ArrayLayout(self._formats.settle, lanes), init=[],
                                              depth=words(self._config, self._level))
        # Words of a row of words, rounded up to a power of two.
        last_word, shift = Signal(self._word_bits), Signal(range(self._word_bits + 1))
        m.d.sync += last_word.eq(self._word((self.columns - 1)[:len(self.columns)]))
        with m.If(last_word == 0):
            m.d.sync += shift.eq(0)
        for bit in range(self._word_bits):
            with m.If(last_word[bit] & ~last_word[bit + 1:].any()):
                m.d.sync += shift.eq(bit + 1)
        read, write = memory.read_port(), memory.write_port(granularity=1)

        def address(column, row):
            return ((row << shift) | column)[:len(read.addr)]

        given, writes, chosen = self.i_square.payload, Signal(), Signal(range(lanes))
        m.d.sync += [
            writes.eq(self.i_square.valid), chosen.eq(Cat(given.column[:SIDE_BITS], given.row[:SIDE_BITS])),
            write.addr.eq(address(given.column[SIDE_BITS:], given.row[SIDE_BITS:])),
            write.data.eq(Cat(given.code for _ in range(lanes)))]
        m.d.comb += write.en.eq(Mux(writes, 1 << chosen, 0))
        return read, address
