"""Stage count: when a stage is over, and when a frustum is."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import GRID_GROUP, CtuFormats
from hw.lib.checks import claim_steps, count_entries

__all__ = ["COUNT_BITS", "NEAR_STAGE", "StageCount", "stage_index_bits"]

# The stage of the near cells: the one before the first requests' stage 0.
NEAR_STAGE = 15
# Grid rays in flight in one stage; the buffers of cell traversal hold far fewer.
COUNT_BITS = 12
# Registers between the end of a ray and the count.
LATENCY = 3


def stage_index_bits(config: Config) -> int:
    """Low bits of a stage's number that distinguish the stages in flight."""
    return max(1, config.ctu.run_ahead.bit_length())


class StageCount(wiring.Component):
    """A stage is over when it is closed, no grid ray of it is in flight, and its cells lead to nothing more.

    Stages end in order. A ray that enters is counted as in flight from the next cycle on, before it reaches the count,
    so a closed stage needs no waiting time.

    Parameters
    ----------
    config
        The configuration.
    exits
        Exits at which grid rays end.

    Members
    -------
    begins : In(1)
        A frustum begins: nothing is in flight, and the near cells' stage is open.
    enters : In, stream of ``stage``, ``count``
        Grid rays that enter. Always ready.
    left : In, array of streams of ``stage``, ``count``
        Grid rays that end, at least one cycle after they entered. Always ready.
    closes : In(1)
        The open stage gets no further cell and no further ray; the next stage opens.
    closed_all : In(1)
        No stage follows the one that closed last.
    settled : In(1)
        No cell is being worked on. Low at the latest in the cycle after a cell has left.
    over : Out(1)
        A stage is over in this cycle.
    near_over : Out(1)
        The near cells' stage is over.
    done : Out(1)
        The frustum is over.
    rays : Out, one bit for each stage in flight
        The stage has grid rays in flight.

    Timing
    ------
    Latency: ``3`` cycles from the end of the last ray to ``over``, 1 cycle from ``closes``. One stage per cycle.
    """

    def __init__(self, *, config: Config, exits: int):
        self._exits, formats = exits, CtuFormats(config)
        self._bits = bits = stage_index_bits(config)
        rays = stream.Signature(StructLayout({"stage": formats.stage, "count": formats.grid_group}), always_ready=True)
        super().__init__({
            "begins": In(1), "enters": In(rays), "left": In(rays).array(exits), "closes": In(1), "closed_all": In(1),
            "settled": In(1), "over": Out(1), "near_over": Out(1), "done": Out(1), "rays": Out(1 << bits)})
        self.latency = LATENCY

    def elaborate(self, platform):
        m = Module()
        bits = self._bits
        busy = Signal(1 << bits)
        for index in range(1 << bits):
            count, following, came, gone = (Signal(width, name=f"{name}_{index}") for name, width in (
                ("count", COUNT_BITS), ("following", COUNT_BITS), ("came", self.enters.payload["count"].shape()),
                ("gone", range(GRID_GROUP * self._exits + 1))))
            # Whether there are rays is known with how many there are.
            some, some_came = Signal(name=f"some_{index}"), Signal(name=f"some_came_{index}")
            entering, *leaving = (Signal(port.payload["count"].shape(), name=f"{name}_{index}") for name, port in (
                ("entering", self.enters), *((f"leaving_{k}", port) for k, port in enumerate(self.left))))
            for port, rays in zip((self.enters, *self.left), (entering, *leaving), strict=True):
                m.d.sync += rays.eq(Mux(port.valid & (port.payload.stage[:bits] == index), port.payload["count"], 0))
            count_entries(count)
            claim_steps(m, count, up=came, down=gone, most=(1 << COUNT_BITS) - 1)
            m.d.comb += [following.eq(count + came - gone), busy[index].eq(entering.any() | some_came | some)]
            m.d.sync += [came.eq(entering), some_came.eq(entering.any()), gone.eq(sum(leaving)), count.eq(following),
                         some.eq(following.any()), self.rays[index].eq(some)]

        # The oldest stage that is not over, and how many stages are closed and not over.
        first = NEAR_STAGE & (1 << bits) - 1
        oldest, closed = Signal(bits, init=first), Signal(range(18))
        m.d.comb += [
            self.over.eq((closed != 0) & ~busy.bit_select(oldest, 1) & self.settled),
            self.done.eq(self.closed_all & (closed == 0))]
        claim_steps(m, closed, up=self.closes & ~self.begins, down=self.over & ~self.begins, most=17)
        m.d.sync += closed.eq(closed + self.closes - self.over)
        with m.If(self.over):
            m.d.sync += [oldest.eq(oldest + 1), self.near_over.eq(1)]
        with m.If(self.begins):
            m.d.sync += [oldest.eq(first), closed.eq(0), self.near_over.eq(0)]
        return m
