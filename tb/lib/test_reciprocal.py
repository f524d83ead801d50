import numpy as np
import pytest

from golden.icu.reciprocal import reciprocal
from hw.lib.reciprocal import Reciprocal
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return Reciprocal(width=config.numbers.mantissa_bits + 2, tag=8)


def vectors(config):
    bits = config.numbers.mantissa_bits + 2
    mantissa = np.random.default_rng(2).integers(1 << bits - 1, 1 << bits, 200)
    mantissa[:4] = [1 << bits - 1, (1 << bits) - 1, (1 << bits - 1) + 1, 3 << bits - 2]
    inverse = reciprocal(mantissa, bits)
    return Vectors(items=[{"tag": k, "mantissa": int(mantissa[k])} for k in range(200)],
                   expected={"o": [{"tag": k, "inverse": int(inverse[k])} for k in range(200)]})


def test_every_width_and_depth():
    check_block(make, vectors, interval=4, variants=[{}], more={"width": 26})


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("reciprocal", make, vectors, simulator=simulator, interval=4)
