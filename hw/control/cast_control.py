"""Cast control: start and end of a frustum in a cluster."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.memsys.serial_product import SerialProduct

__all__ = ["CastControl"]

# Patches in the intersection unit, more than its capacity.
PATCHES = 1023


class CastControl(wiring.Component):
    """Starts a frustum in a cluster's units, and detects its end.

    The memory system and the intersection unit start first, then cell traversal and the near cells. A cast has ended
    when the traversal has sent its final item, the memory system is drained, and each patch that entered the
    intersection unit is done. A section with more tiles than the ray memory has is not started.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream without payload
        Casts. Accepted when the previous one has ended.
    busy : Out(1)
        A cast is in progress.
    cycles : Out(32)
        Its cycles, or those of the last one.
    wrong : Out(1)
        The section is too large, in the cycle in which the cast ends.
    section : In(Formats.section)
        Of the cluster.
    tiles_across : Out(Formats.count)
        Tiles in a row of tiles of the section.
    o_memory, o_intersection, o_traversal, o_near : Out, stream without payload
        Start the memory system, the intersection unit, the traversal unit, and the near cells.
    final, drained : In(1)
        The traversal sends its final item; the memory system is drained.
    enters, leaves : In(1)
        A patch enters the intersection unit; a patch is done.
    idle : Out(1)
        No cell and no patch is in flight.

    Timing
    ------
    Latency: ``6 + bits(tiles_down)`` cycles from a cast of so many rows of tiles to the start of the memory system and
    of the intersection unit.
    """

    def __init__(self, *, config: Config):
        self._config, formats = config, Formats(config)
        begins = Out(stream.Signature(0))
        super().__init__({
            "i": In(stream.Signature(0)), "busy": Out(1), "cycles": Out(32), "wrong": Out(1),
            "section": In(formats.section), "tiles_across": Out(formats.count), "o_memory": begins,
            "o_intersection": begins, "o_traversal": begins, "o_near": begins, "final": In(1), "drained": In(1),
            "enters": In(1), "leaves": In(1), "idle": Out(1)})

    def elaborate(self, platform):
        m = Module()
        icu, section = self._config.icu, self.section
        columns, rows, down = (Signal.like(section.end_row, name=name) for name in ("columns", "rows", "down"))
        side = (1 << icu.tile_bits) - 1
        m.d.sync += [columns.eq(section.end_column - section.first_column),
                     rows.eq(section.end_row - section.first_row),
                     self.tiles_across.eq((columns + side) >> icu.tile_bits), down.eq((rows + side) >> icu.tile_bits)]

        # Tiles of the section.
        capacity = icu.rays >> 2 * icu.tile_bits
        m.submodules.tiles = tiles = SerialProduct(a=len(down), b=len(down))
        m.d.comb += [tiles.i.payload.a.eq(self.tiles_across), tiles.i.payload.b.eq(down)]
        steps = Signal(2)
        over, settled, patches = Signal(), Signal(), Signal(range(PATCHES + 1))
        too_many = Signal()
        m.d.sync += patches.eq(patches + self.enters - self.leaves)
        m.d.comb += self.idle.eq(self.drained & (patches == 0))
        # Registered: the units are far away.
        starts = {name: Signal(name=f"starts_{name}") for name in ("memory", "intersection", "traversal", "near")}
        for name, start in starts.items():
            unit = getattr(self, f"o_{name}")
            m.d.comb += unit.valid.eq(start)
            with m.If(unit.ready):
                m.d.sync += start.eq(0)

        def begin(*names):
            m.d.sync += [starts[name].eq(1) for name in names]

        with m.If(self.final):
            m.d.sync += over.eq(1)
        with m.If(self.busy):
            m.d.sync += self.cycles.eq(self.cycles + 1)
        m.d.comb += self.busy.eq(1)
        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [self.i.ready.eq(1), self.busy.eq(0)]
                m.d.sync += [over.eq(0), steps.eq(0)]
                with m.If(self.i.valid):
                    m.d.sync += self.cycles.eq(0)
                    m.next = "Take"
            # A section that has just been loaded passes two registers: columns, then tiles.
            with m.State("Take"):
                m.d.sync += steps.eq(steps + 1)
                m.d.comb += tiles.i.valid.eq(steps == 2)
                with m.If(steps == 2):
                    m.next = "Multiply"
            with m.State("Multiply"):
                m.d.comb += tiles.o.ready.eq(1)
                m.d.sync += too_many.eq(tiles.o.payload > capacity)
                with m.If(tiles.o.valid):
                    m.next = "Decide"
            with m.State("Decide"):
                with m.If(too_many):
                    m.d.comb += self.wrong.eq(1)
                    m.next = "Wait"
                with m.Else():
                    begin("memory", "intersection")
                    m.next = "Begin"
            with m.State("Begin"), m.If(~starts["memory"] & ~starts["intersection"]):
                begin("traversal", "near")
                m.next = "Traverse"
            with m.State("Traverse"), m.If(~starts["traversal"] & ~starts["near"]):
                m.next = "Cast"
            # A cell that leaves together with the final item is counted a cycle later.
            with m.State("Cast"):
                m.d.sync += settled.eq(over & self.idle)
                with m.If(settled & self.idle):
                    m.d.sync += settled.eq(0)
                    m.next = "Wait"
        return m
