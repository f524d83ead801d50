import numpy as np
import pytest
from amaranth.hdl import Const, signed, unsigned

from golden.engine.config import Icu
from golden.engine.lib.cordic import circular, linear
from hw.lib.cordic import accumulator_bits, cordic
from tb.lib.operator_bench import run_operator

BITS = 17
SETTINGS = [Icu(), Icu(cordic_guard=0, angle_bits=18), *(pytest.param(icu, marks=pytest.mark.nightly) for icu in (
    Icu(cordic_stages=8), Icu(cordic_stages=20, cordic_guard=8)))]


def pairs():
    """Pairs of all directions, axes, diagonals and near misses of them first."""
    top = (1 << BITS) - 1
    edge = np.array([-top, -top + 1, -1, 0, 1, 1 << BITS - 1, top - 1, top])
    x, y = np.random.default_rng(7).integers(-top, top + 1, (2, 200))
    return np.concatenate([np.repeat(edge, 8), x]), np.concatenate([np.tile(edge, 8), y])


def run(icu, x, y, *, is_linear, shape, interval=1):
    width = BITS + icu.cordic_guard + 4
    return run_operator(
        [signed(width)] * 2, [shape, signed(width)],
        lambda p, x, y: list(cordic(p, x, y, linear=p.constant(Const(is_linear)), icu=icu, width=width)),
        [x << icu.cordic_guard, y << icu.cordic_guard], interval=interval)


@pytest.mark.parametrize("icu", SETTINGS, ids=str)
def test_angles_and_lengths(icu):
    x, y = pairs()
    (angle, length), latency = run(icu, x, y, is_linear=0, shape=unsigned(icu.angle_bits))
    expected = circular(x << icu.cordic_guard, y << icu.cordic_guard, icu)
    assert angle == expected[0].tolist()
    assert length == expected[1].tolist()
    assert latency == icu.cordic_stages + 2


@pytest.mark.parametrize("icu", SETTINGS, ids=str)
def test_quotients(icu):
    x, y = pairs()
    x, y = np.maximum(np.abs(x), np.abs(y)), np.where(np.abs(x) < np.abs(y), x, y)
    x, y = x[x > 0], y[x > 0]
    (quotient, _), latency = run(icu, x, y, is_linear=1, shape=signed(accumulator_bits(icu)))
    assert quotient == linear(y, x, icu).tolist()
    assert latency == icu.cordic_stages + 2


@pytest.mark.parametrize("interval", [6, 17, 18, 25])
def test_stages_of_items_far_apart(interval):
    icu, (x, y) = Icu(), (value[::5] for value in pairs())
    (angle, length), latency = run(icu, x, y, is_linear=0, shape=unsigned(icu.angle_bits), interval=interval)
    expected = circular(x << icu.cordic_guard, y << icu.cordic_guard, icu)
    assert angle == expected[0].tolist()
    assert length == expected[1].tolist()
    assert latency == icu.cordic_stages + 2
