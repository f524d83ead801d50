"""CORDIC in vectoring mode as steps of a pipeline: angles and lengths (circular), quotients (linear)."""

from amaranth.hdl import Const, Mux, Value

from golden.config import Icu
from golden.cordic import turns
from hw.lib.fixed import add_or_subtract
from hw.lib.pipeline import Pipeline, Staged

__all__ = ["accumulator_bits", "cordic"]


def accumulator_bits(icu: Icu) -> int:
    """Bits of an angle or of a quotient from -1 to 1."""
    return max(icu.angle_bits, icu.cordic_stages + 2)


def cordic(pipeline: Pipeline, x: Staged, y: Staged, *, linear: Value, icu: Icu, width: int) -> tuple[Staged, Staged]:
    """Angle from the x axis and length of (x, y), or the quotient y / x.

    Circular: stage k = 0, 1, ... turns by atan(2^-k) towards y = 0, after a half turn for x < 0. Linear: stage
    k = 1, 2, ... takes 2^-k x from y. So one set of ``icu.cordic_stages`` + 1 stages does both.

    Parameters
    ----------
    x, y
        Signed, with ``icu.cordic_guard`` bits behind the point.
    linear
        Which of the two; the same while items are under way.
    width
        Bits that x and y need on their way.

    Returns
    -------
    Angle (low ``angle_bits`` bits) or quotient (signed, in units of 2^-``cordic_stages``) in `accumulator_bits` bits,
    and the length times `golden.cordic.gain`. ``cordic_stages + 2`` cycles.

    Golden counterpart: `golden.cordic.circular`, `golden.cordic.linear`.
    """
    bits, stages = accumulator_bits(icu), icu.cordic_stages
    circular = [*turns(icu), 0]
    quotient = [0, *(1 << stages - k for k in range(1, stages + 1))]

    def forward(value, behind):
        return Mux(behind, -value, value)[:width].as_signed()

    behind = pipeline.combine(lambda x: x[-1] & ~linear, x)
    angle = pipeline.register(lambda behind: Mux(behind, Const(1 << icu.angle_bits - 1, bits), 0), behind)
    x, y = (pipeline.register(forward, value, behind) for value in (x, y))
    for k in range(stages + 1):
        above = pipeline.combine(lambda y: ~y[-1], y)
        turn = Mux(linear, Const(quotient[k], bits), Const(int(circular[k]), bits))

        def stepped(value, step, subtract, idle):
            moved = add_or_subtract(value, step, subtract)[:len(value)].as_signed()
            return moved if idle is None else Mux(idle, value, moved).as_signed()

        # A stage that only one of the two has leaves the other's numbers as they are.
        idle_y = linear if k == 0 else ~linear if k == stages else None
        idle_x = linear if k < stages else Const(1)
        next_x = pipeline.register(lambda x, y, above, k=k, idle=idle_x: stepped(x, y >> k, ~above, idle), x, y, above)
        next_y = pipeline.register(lambda x, y, above, k=k, idle=idle_y: stepped(y, x >> k, above, idle), x, y, above)
        angle = pipeline.register(lambda angle, above, turn=turn: stepped(angle, turn, ~above, None), angle, above)
        x, y = next_x, next_y
    return angle, x
