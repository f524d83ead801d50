from functools import partial

import numpy as np

from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from hw.icu.ray_direction import RayDirection
from radiosity.flow.package.example.frustum_load import table_writes
from tb.icu.vectors import rows
from tb.lib.bench import Bench, Vectors


def of_record(frustum, config):
    random = np.random.default_rng(1)
    record = frustum(random, config)
    column, row = random.integers(record.columns, size=400), random.integers(record.rows, size=400)
    directions = rows(record.directions(column, row))
    return Vectors(
        ports={"is_screen": int(record.is_screen)}, first={"i_table": table_writes(record, config)},
        inputs={"i": [{"tag": k, "column": int(column[k]), "row": int(row[k])} for k in range(400)]},
        expected={"o": [{"tag": k, "direction": directions[k]} for k in range(400)]})


class TestRayDirection(Bench):
    component, arguments = RayDirection, {"tag": 9}
    cases = {frustum.__name__: partial(of_record, frustum) for frustum in (random_hemisphere, random_screen)}
