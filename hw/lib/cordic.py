"""CORDIC in vectoring mode as steps of a pipeline: angles and lengths (circular), quotients (linear)."""

from amaranth.hdl import Array, Const, Mux

from golden.engine.config import Icu
from golden.engine.lib.cordic import rotations
from hw.lib.fixed import add_or_subtract
from hw.lib.pipeline import Pipeline, Staged

__all__ = ["accumulator_bits", "cordic"]


def accumulator_bits(icu: Icu) -> int:
    """Bits of an angle or of a quotient from -1 to 1."""
    return max(icu.angle_bits, icu.cordic_stages + 2)


def cordic(pipeline: Pipeline, x: Staged, y: Staged, *, linear: Staged, icu: Icu, width: int) -> tuple[Staged, Staged]:
    """Angle from the x axis and length of (x, y), or the quotient y / x.

    Circular: stage k = 0, 1, ... turns by atan(2^-k) towards y = 0, after a half turn for x < 0. Linear: stage
    k = 1, 2, ... takes 2^-k x from y. So one set of ``icu.cordic_stages`` + 1 stages does both.

    Parameters
    ----------
    x, y
        Signed, with ``icu.cordic_guard`` bits behind the point.
    linear
        Which of the two.
    width
        Bits that x and y need at every stage.

    Returns
    -------
    Angle (low ``angle_bits`` bits) or quotient (signed, in units of 2^-``cordic_stages``) in `accumulator_bits` bits,
    and the length times `golden.engine.lib.cordic.gain`. ``cordic_stages + 2`` cycles; where items are far apart,
    stages share adders (`Pipeline.rounds`).

    Golden counterpart: `golden.engine.lib.cordic.circular`, `golden.engine.lib.cordic.linear`.
    """
    bits, stages = accumulator_bits(icu), icu.cordic_stages
    circular = Array(Const(int(turn), bits) for turn in [*rotations(icu), 0])
    quotient = Array(Const(step, bits) for step in [0, *(1 << stages - k for k in range(1, stages + 1))])

    def forward(value, behind):
        return Mux(behind, -value, value)[:width].as_signed()

    def stepped(value, step, subtract, idle):
        return Mux(idle, value, add_or_subtract(value, step, subtract)[:len(value)].as_signed()).as_signed()

    def stage(k, x, y, angle, linear):
        above = ~y[-1]
        # A stage that only one of the two has leaves the other's numbers as they are.
        idle_x, idle_y = linear | (k == stages), (linear & (k == 0)) | (~linear & (k == stages))
        return (stepped(x, y >> k, ~above, idle_x), stepped(y, x >> k, above, idle_y),
                stepped(angle, Mux(linear, quotient[k], circular[k]), ~above, 0), linear)

    behind = pipeline.combine(lambda x, linear: x[-1] & ~linear, x, linear)
    angle = pipeline.combine(lambda behind: Mux(behind, Const(1 << icu.angle_bits - 1, bits), 0).as_signed(), behind)
    # Sideband: a single register would have a fan-out to all stages.
    x, y, angle, _ = pipeline.rounds(
        stage, stages + 1, *(pipeline.combine(forward, value, behind) for value in (x, y)), angle, linear)
    return angle, x
