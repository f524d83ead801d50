from functools import partial

import numpy as np

from golden.engine.frustum.bundle import Bundle
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from hw.icu.ray_direction import RayDirection
from radiosity.flow.package.example.frustum_load import table_writes
from tb.icu.shadow_frustum import random_shadow
from tb.icu.vectors import SHADOWS, rows
from tb.lib.bench import VARIANTS, Bench, Case, Vectors


def of_record(frustum, config):
    random = np.random.default_rng(1)
    record = frustum(random, config)
    column, row = random.integers(record.columns, size=400), random.integers(record.rows, size=400)
    directions = rows(record.directions(column, row))
    shadow, place, first = {}, [{}] * 400, {"i_table": table_writes(record, config)}
    if config.icu.shadow_bits:
        shadow = {"is_shadow": int(record.bundle == Bundle.SHADOW)}
        place = [{"ray": int(ray)} for ray in row * record.columns + column]
    if record.bundle == Bundle.SHADOW:
        first["i_ray"] = [{"ray": ray, "x": x, "y": y} for ray, (x, y) in enumerate(rows(
            record.all_directions()[:, :2] + (1 << config.numbers.direction_fraction)))]
    return Vectors(
        ports={"is_screen": int(record.is_screen), **shadow}, first=first,
        inputs={"i": [{"tag": k, "column": int(column[k]), "row": int(row[k]), **place[k]} for k in range(400)]},
        expected={"o": [{"tag": k, "direction": directions[k]} for k in range(400)]})


class TestRayDirection(Bench):
    component, arguments = RayDirection, {"tag": 9}
    cases = {frustum.__name__: Case(partial(of_record, frustum), [*VARIANTS, *SHADOWS])
             for frustum in (random_hemisphere, random_screen)}
    cases["random_shadow"] = Case(partial(of_record, random_shadow), SHADOWS, simulated=False)
