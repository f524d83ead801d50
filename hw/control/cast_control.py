"""Cast control: begins a frustum in a cluster's units, and says when it is over."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats

__all__ = ["CastControl"]

# Patches in the intersection unit: more than it takes.
PATCHES = 1023


class CastControl(wiring.Component):
    """The memory system and the intersection unit begin a frustum first, then cell traversal and its near cells.

    A cast is over when the traversal has sent its final item, the memory system is drained, and each patch that went
    into the intersection unit has come back. A section that the ray memory has no room for is not begun.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        Casts. Taken when the last one is over. No payload.
    busy, cycles
        A cast is under way; cycles of the present one, or the last.
    wrong
        The section is too large: in the cycle in which the cast ends.
    section, tiles_across
        The cluster's section, and tiles across it.
    o_memory, o_intersection, o_traversal, o_near
        Begin a frustum: of the memory system, the intersection unit, the traversal unit, and the near cells. No
        payload.
    final, drained
        The traversal is over, in the cycle in which it says so; the memory system says that it is drained.
    enters, leaves
        A patch goes into the intersection unit, and comes back.
    idle
        Nothing is being done for any cell.

    Timing
    ------
    Latency: ``side_bits + 7`` cycles from a cast to the beginning of the memory system's and the intersection unit's.
    """

    def __init__(self, *, config: Config):
        self._config, formats = config, Formats(config)
        begins = Out(stream.Signature(0))
        super().__init__({
            "i": In(stream.Signature(0)), "busy": Out(1), "cycles": Out(32), "wrong": Out(1),
            "section": In(formats.section), "tiles_across": Out(formats.count), "o_memory": begins,
            "o_intersection": begins, "o_traversal": begins, "o_near": begins, "final": In(1), "drained": In(1),
            "enters": In(1), "leaves": In(1), "idle": Out(1)})
        self.latency = config.icu.side_bits + 7

    def elaborate(self, platform):
        m = Module()
        icu, section = self._config.icu, self.section
        columns, rows, down = (Signal.like(section.end_row, name=name) for name in ("columns", "rows", "down"))
        side = (1 << icu.tile_bits) - 1
        m.d.sync += [columns.eq(section.end_column - section.first_column),
                     rows.eq(section.end_row - section.first_row),
                     self.tiles_across.eq((columns + side) >> icu.tile_bits), down.eq((rows + side) >> icu.tile_bits)]

        # Tiles of the section: those across are added up bit by bit of those down.
        room = icu.rays >> 2 * icu.tile_bits
        tiles, term = (Signal(2 * len(down), name=name) for name in ("tiles", "term"))
        factor, bits = Signal.like(down), Signal(range(len(down) + 1))
        over, settled, patches = Signal(), Signal(), Signal(range(PATCHES + 1))
        too_many = Signal()
        m.d.sync += patches.eq(patches + self.enters - self.leaves)
        m.d.comb += self.idle.eq(self.drained & (patches == 0))
        # Those that take it are far away: what is offered is in registers.
        asks = {name: Signal(name=f"asks_{name}") for name in ("memory", "intersection", "traversal", "near")}
        for name, ask in asks.items():
            one = getattr(self, f"o_{name}")
            m.d.comb += one.valid.eq(ask)
            with m.If(one.ready):
                m.d.sync += ask.eq(0)

        def begin(*names):
            m.d.sync += [asks[name].eq(1) for name in names]

        with m.If(self.final):
            m.d.sync += over.eq(1)
        with m.If(self.busy):
            m.d.sync += self.cycles.eq(self.cycles + 1)
        m.d.comb += self.busy.eq(1)
        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [self.i.ready.eq(1), self.busy.eq(0)]
                m.d.sync += [over.eq(0), bits.eq(0)]
                with m.If(self.i.valid):
                    m.d.sync += self.cycles.eq(0)
                    m.next = "Take"
            # Of a section that has just been loaded: columns, then tiles.
            with m.State("Take"):
                m.d.sync += [bits.eq(bits + 1), tiles.eq(0), term.eq(self.tiles_across), factor.eq(down)]
                with m.If(bits == 2):
                    m.d.sync += bits.eq(0)
                    m.next = "Multiply"
            with m.State("Multiply"):
                m.d.sync += [term.eq(term << 1), factor.eq(factor >> 1), bits.eq(bits + 1),
                             tiles.eq(tiles + Mux(factor[0], term, 0))]
                with m.If(bits == len(down) - 1):
                    m.next = "Compare"
            with m.State("Compare"):
                m.d.sync += too_many.eq(tiles > room)
                m.next = "Decide"
            with m.State("Decide"):
                with m.If(too_many):
                    m.d.comb += self.wrong.eq(1)
                    m.next = "Wait"
                with m.Else():
                    begin("memory", "intersection")
                    m.next = "Begin"
            with m.State("Begin"), m.If(~asks["memory"] & ~asks["intersection"]):
                begin("traversal", "near")
                m.next = "Traverse"
            with m.State("Traverse"), m.If(~asks["traversal"] & ~asks["near"]):
                m.next = "Cast"
            # A cell that leaves beside the final item shows a cycle later.
            with m.State("Cast"):
                m.d.sync += settled.eq(over & self.idle)
                with m.If(settled & self.idle):
                    m.d.sync += settled.eq(0)
                    m.next = "Wait"
        return m
