import numpy as np

from golden.engine.icu.reciprocal import reciprocal
from hw.lib.reciprocal import Reciprocal
from tb.lib.bench import Bench, Vectors


class TestReciprocal(Bench):
    variants, interval, formula = ({},), 4, {"width": 26}

    def make(self, config):
        return Reciprocal(width=config.numbers.mantissa_bits + 2, tag=8)

    def vectors(self, config):
        bits = config.numbers.mantissa_bits + 2
        mantissa = np.random.default_rng(2).integers(1 << bits - 1, 1 << bits, 200)
        mantissa[:4] = [1 << bits - 1, (1 << bits) - 1, (1 << bits - 1) + 1, 3 << bits - 2]
        inverse = reciprocal(mantissa, bits)
        return Vectors(inputs={"i": [{"tag": k, "mantissa": int(mantissa[k])} for k in range(200)]},
                       expected={"o": [{"tag": k, "inverse": int(inverse[k])} for k in range(200)]})
