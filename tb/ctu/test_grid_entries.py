from functools import partial

import numpy as np

from golden.engine.stimulus.ctu.grids import shells
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.grid_entries import GridEntries
from radiosity.flow.package.example.grid_load import GridAddresses, grid_writes
from tb.lib.bench import Bench, Vectors

RAYS, SHELLS = 400, range(2, 16)


def of_record(frustum, config):
    random, formats = np.random.default_rng(2), CtuFormats(config)
    record = frustum(random, config)
    rays = [shells(record)(shell) for shell in SHELLS]
    # As far away, and as long, as tables can say.
    begins, lengths = (random.integers(1 << shape.width, size=len(rays))
                       for shape in (formats.begin, formats.parameter))
    ways = {one.shell: (int(begin), int(begin + length))
            for one, begin, length in zip(rays, begins, lengths, strict=True)}
    addresses, items, expected = GridAddresses(rays), [], []
    for tag in range(RAYS):
        one = rays[random.integers(len(rays))]
        number = int(random.integers(one.rows * one.columns))
        request, (row, column) = addresses.request(one, number), divmod(number, one.columns)
        begin, end = ways[one.shell]
        items.append({"tag": tag, **{name: request[name] for name in ("shell", "row", "column")}})
        # The second number of a screen's entries is 0.
        expected.append({"tag": tag, "begin": begin, "length": end - begin, "row": one.row_table[row].tolist(),
                         "column": one.column_table[column].tolist()})
    return Vectors(inputs={"i": items}, expected={"o": expected},
                   first={"i_table": grid_writes(rays, config, ways=ways)})


class TestGridEntries(Bench):
    component, arguments = GridEntries, {"tag": 9}
    variants = [{}]
    cases = {frustum.__name__: partial(of_record, frustum) for frustum in (random_hemisphere, random_screen)}
