"""Section cast: start and end of one section after the other in a cluster's units."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import Formats
from hw.lib.checks import count_steps
from hw.lib.start_all import StartAll

__all__ = ["SectionCast"]

# Patches in the intersection unit, more than its capacity.
PATCHES = 1023
# Units behind cell traversal, which begin before it, and those that feed them.
_UNITS = ("memory", "intersection", "traversal", "near")


class SectionCast(wiring.Component):
    """Starts a section in a cluster's units, detects its end, and has its results read out.

    The memory system and the intersection unit start first, then cell traversal and the near cells. A cast has ended
    when the traversal has sent its final item, the memory system is drained, and each patch that entered the
    intersection unit is done. The next section starts when the results of the ended one are being read out: the ray
    memory's other bank is free then, or becomes free.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `Formats.section`
        The next section; accepted when all units have begun it.
    begins : Out(1)
        The units begin it: what belongs to it is taken from the slot.
    o_results : Out, stream without payload
        A cast has ended; accepted when its read-out has begun.
    free : Out(1)
        No section waits, and the present one, if any, has no further requests for grid rays and no cell or patch in
        flight before the intersection unit.
    busy : Out(1)
        A section is being cast, or waits for its read-out.
    cycles : Out(32)
        Cycles of the present cast, or those of the last one.
    tiles_across : Out(Formats.count)
        Tiles in a row of tiles of the section.
    o_memory, o_intersection, o_traversal, o_near : Out, stream without payload
        Start the memory system, the intersection unit, the traversal unit, and the near cells.
    closed, ends, drained : In(1)
        The traversal has accepted all requests of the present section; it sends its final item; the memory system is
        drained.
    enters, leaves : In(1)
        A patch enters the intersection unit; a patch is done.
    idle : Out(1)
        No cell and no patch is in flight.

    Timing
    ------
    Latency: ``2`` cycles from a section to the start of the memory system and of the intersection
    unit; of one that has waited ``1``. The results of a cast are offered 3 cycles after its last patch is done.
    """

    latency = 2

    def __init__(self, *, config: Config):
        self._config, formats = config, Formats(config)
        starts = Out(stream.Signature(0))
        super().__init__({
            "i": In(stream.Signature(formats.section)), "begins": Out(1), "o_results": starts, "free": Out(1),
            "busy": Out(1), "cycles": Out(32), "tiles_across": Out(formats.count),
            **{f"o_{name}": starts for name in _UNITS}, "closed": In(1), "ends": In(1), "drained": In(1),
            "enters": In(1), "leaves": In(1), "idle": Out(1)})

    def elaborate(self, platform):
        m = Module()
        section, bits = self.i.payload, self._config.icu.tile_bits
        columns = Signal.like(section.end_column)
        m.d.sync += [columns.eq(section.end_column - section.first_column),
                     self.tiles_across.eq((columns + (1 << bits) - 1) >> bits)]
        over, settled, patches, known = Signal(), Signal(), Signal(range(PATCHES + 1)), Signal()
        count_steps(m, patches, up=self.enters, down=self.leaves, most=PATCHES)
        m.d.sync += known.eq(self.i.valid & ~self.i.ready)
        m.d.comb += [self.idle.eq(self.drained & (patches == 0)), self.busy.eq(1)]
        m.submodules.behind, m.submodules.before = behind, before = StartAll(count=2), StartAll(count=2)
        for start, name in zip((*behind.o, *before.o), _UNITS, strict=True):
            wiring.connect(m, start, wiring.flipped(getattr(self, f"o_{name}")))
        with m.If(self.ends):
            m.d.sync += over.eq(1)
        m.d.comb += self.free.eq(~self.i.valid & (over | (self.closed & self.drained) | ~self.busy))
        with m.FSM():
            # The tiles follow a section by two registers.
            with m.State("Wait"):
                m.d.comb += self.busy.eq(0)
                with m.If(self.i.valid & known):
                    m.d.comb += [self.busy.eq(1), self.begins.eq(1), behind.i.valid.eq(1)]
                    m.d.sync += [over.eq(0), self.cycles.eq(0)]
                    m.next = "Begin"
            with m.State("Begin"):
                m.d.comb += [behind.i.valid.eq(1), before.i.valid.eq(behind.i.ready)]
                with m.If(behind.i.ready):
                    m.next = "Traverse"
            with m.State("Traverse"):
                m.d.comb += [before.i.valid.eq(1), self.i.ready.eq(before.i.ready)]
                with m.If(before.i.ready):
                    m.next = "Cast"
            # A cell that leaves together with the final item is counted a cycle later.
            with m.State("Cast"):
                m.d.sync += settled.eq(over & self.idle)
                with m.If(settled & self.idle):
                    m.d.sync += settled.eq(0)
                    m.next = "Results"
            with m.State("Results"):
                m.d.comb += self.o_results.valid.eq(1)
                with m.If(self.o_results.ready):
                    m.next = "Wait"
        with m.If(self.busy & ~self.o_results.valid & ~self.begins):
            m.d.sync += self.cycles.eq(self.cycles + 1)
        return m
