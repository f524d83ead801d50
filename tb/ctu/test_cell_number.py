import numpy as np

from hw.ctu.cell_number import CellNumber
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import DEPTHS

COUNT = 200


class TestCellNumber(Bench):
    component, arguments = CellNumber, {"tag": 9}
    variants = [{"icu.product_registers": depth} for depth in DEPTHS]
    # A cube, and the longest grids along an axis.
    cases = {str(shape): lambda config, shape=shape: of_grid(shape, config)
             for shape in ((20, 30, 40), (3, 2, 1000), (1000, 2, 3), (1, 1, 1))}


def of_grid(shape, config):
    """The first cell, the last one, and others; golden's number is `CellTable.number`."""
    random = np.random.default_rng(1)
    index = random.integers(shape, size=(COUNT, 3))
    index[0], index[1] = 0, np.array(shape) - 1
    number = np.ravel_multi_index(index.T, shape)
    return Vectors(ports={"shape": list(shape)},
                   inputs={"i": [{"tag": k, "index": cell} for k, cell in enumerate(index.tolist())]},
                   expected={"o": [{"tag": k, "cell": cell} for k, cell in enumerate(number.tolist())]})
