"""Stage count: when a stage, and when a frustum is over."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.ctu.ctu_formats import GRID_GROUP, CtuFormats

__all__ = ["COUNT_BITS", "FIRST", "StageCount", "stage_index_bits"]

# The number of the stage of the near cells, the one before the first requests'.
FIRST = 15
# Of the grid rays of a stage that are under way: more than there is room for.
COUNT_BITS = 12
# Cycles from a closed stage's last event until its count says so.
SETTLES = 5


def stage_index_bits(config: Config) -> int:
    """Stages under way are told apart by so many low bits of their numbers: there are ``lead`` more than one."""
    return max(1, config.ctu.run_ahead.bit_length())


class StageCount(wiring.Component):
    """A stage is over when no further grid ray of it is asked for, none is under way, and what its cells have led to is
    done; stages are over in their order.

    Parameters
    ----------
    config
        The configuration.
    leaves
        Places where grid rays end.

    Members
    -------
    begins
        A frustum: nothing is under way, and the near cells' stage is open.
    enters, left
        ``stage`` and ``count`` of grid rays that come in, and of those that end; a ray ends in a later cycle than it
        comes in. An array of streams. Always ready.
    closes
        The present stage, the near cells' at first, has no further cell or ray: the next one is open.
    closed_all
        No stage follows the one that closed last.
    settled
        For each index of a stage, its low bits: nothing is being done for a cell of such a stage. Low in the cycle
        after a cell has left at the latest.
    over
        A stage is over in this cycle.
    near_over
        The near cells' stage is.
    done
        The frustum is.
    rays
        Stages with grid rays under way.

    Timing
    ------
    Latency: ``5`` cycles from the end of the last ray, or from the one that closes the stage. A stage every 5 cycles.
    """

    def __init__(self, *, config: Config, leaves: int):
        self._leaves, formats = leaves, CtuFormats(config)
        self._bits = bits = stage_index_bits(config)
        ends = stream.Signature(StructLayout({"stage": formats.stage, "count": formats.grid_group}), always_ready=True)
        super().__init__({
            "begins": In(1), "enters": In(ends), "left": In(ends).array(leaves), "closes": In(1), "closed_all": In(1),
            "settled": In(1 << bits), "over": Out(1), "near_over": Out(1), "done": Out(1), "rays": Out(1 << bits)})
        self.latency = SETTLES

    def elaborate(self, platform):
        m = Module()
        bits = self._bits
        counts = [Signal(COUNT_BITS, name=f"count_{index}") for index in range(1 << bits)]
        for index, count in enumerate(counts):
            comes, came, gone = (Signal(range(GRID_GROUP * self._leaves + 1), name=f"{name}_{index}")
                                 for name in ("comes", "came", "gone"))
            goes = [Signal(left.payload["count"].shape(), name=f"goes_{index}") for left in self.left]
            for source, target in zip((self.enters, *self.left), (comes, *goes), strict=True):
                m.d.sync += target.eq(Mux(source.valid & (source.payload.stage[:bits] == index),
                                          source.payload["count"], 0))
            m.d.sync += [came.eq(comes), gone.eq(sum(goes)), count.eq(count + came - gone),
                         self.rays[index].eq(count.any())]

        # The oldest stage that is not over, and how many after it are open or closed.
        first = FIRST & (1 << bits) - 1
        oldest, ahead, waits = Signal(bits, init=first), Signal(range(18)), Signal(range(SETTLES))
        under_way = Cat(count.any() for count in counts).bit_select(oldest, 1)
        settled = self.settled.bit_select(oldest, 1)
        m.d.comb += [
            self.over.eq((ahead != 0) & (waits == SETTLES - 1) & ~under_way & settled),
            self.done.eq(self.closed_all & (ahead == 0))]
        m.d.sync += [ahead.eq(ahead + self.closes - self.over),
                     waits.eq(Mux((ahead == 0) | self.over, 0, Mux(waits == SETTLES - 1, waits, waits + 1)))]
        with m.If(self.over):
            m.d.sync += [oldest.eq(oldest + 1), self.near_over.eq(1)]
        with m.If(self.begins):
            m.d.sync += [oldest.eq(first), ahead.eq(0), self.near_over.eq(0), waits.eq(0)]
        return m
