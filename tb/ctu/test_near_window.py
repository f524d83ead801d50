from dataclasses import replace
from functools import partial

import numpy as np

from golden.engine.ctu.grid_rays import INDEX_FRACTION
from golden.engine.stimulus.ctu.grid_rays import draw_rays
from golden.engine.stimulus.ctu.grids import shells
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from hw.ctu.ctu_formats import GRID_GROUP, CtuFormats
from hw.ctu.near_window import NearWindow
from radiosity.flow.package.example.grid_load import GridAddresses, grid_writes
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import CONFIGURATIONS
from tb.lib.runner import SLOW_IN_ICARUS

RAYS = 240


def of_record(frustum, config):
    random = np.random.default_rng(3)
    record = frustum(random, config)
    drawn, rays_of = draw_rays(random, record, RAYS), shells(record)
    # Near shells too, whose rays stand for all columns.
    drawn["shell"] = np.minimum(drawn["shell"], 2 + np.arange(RAYS) % 9)
    rays = [rays_of(shell) for shell in range(2, int(drawn["shell"].max()) + 1)]
    addresses, thresholds = GridAddresses(rays), {one.shell: 10 + 3 * one.shell for one in rays}
    items, expected = [], []
    for tag, (shell, row, column) in enumerate(zip(*(drawn[name].tolist() for name in ("shell", "row", "column")),
                                                   strict=True)):
        one = rays[shell - 2]
        row, column = row % one.rows, column % one.columns
        request = addresses.request(one, row * one.columns + column)
        items.append({"tag": tag, "last": request["column"],
                      **{name: request[name] for name in ("shell", "row", "column")}})
        # A window of no columns may begin anywhere.
        expected.append({"tag": tag, "threshold": thresholds[shell], "window": {
            "column_first": one.first_column[row, column], "column_count": one.column_count[row, column],
            "row_first": one.first_row[row], "row_count": one.row_count[row]}})
    counts = np.array([item["window"]["column_count"] for item in expected])
    assert (counts == record.columns).any(), "some rays must stand for all columns"
    assert (counts < record.columns).any(), "some rays must not"
    return Vectors(ports={"is_screen": int(record.is_screen), "columns": record.columns}, inputs={"i": items},
                   expected={"o": expected}, first={"i_table": grid_writes(rays, config, thresholds=thresholds)})


def neighbours(frustum, config):
    """Windows of all that lies between the first and the last of neighbours."""
    random = np.random.default_rng(5)
    record = frustum(random, config)
    rays_of = shells(record)
    rays = [rays_of(shell) for shell in range(2, 11)]
    chosen = list(choose(random, rays, RAYS // 2))
    for one, row, column, last in chosen:
        first, count = columns_near(record, one, row, column, last)
        if count:
            # All that is near one of the neighbours.
            for neighbour in range(column, last + 1):
                offsets = (int(one.first_column[row, neighbour]) - first + np.arange(one.column_count[row, neighbour]))
                assert (offsets % record.columns < count).all()
    return of_neighbours(config, record, rays, chosen)


def far_neighbours(frustum, config):
    """The same in the widest frustum, of rays that are as far on either side, and reach as far, as tables can say."""
    random, formats = np.random.default_rng(6), CtuFormats(config)
    side = 1 << formats.index.width
    record = frustum(random, config, size=(side, side))
    rays_of, farthest, rays = shells(record), 1 << formats.position.width - 1, []
    for shell in range(2, 11):
        one = rays_of(shell)
        away = int(random.choice([-1, 1]) * 2 ** random.uniform(INDEX_FRACTION, formats.position.width - 1))
        reach = (2 ** random.uniform(0, formats.reach.width, one.rows)).astype(np.int64)
        rays.append(replace(one, column_position=np.clip(one.column_position + away, -farthest, farthest - 1),
                            column_reach=np.where(random.random(one.rows) < 0.5, one.column_reach, reach)))
    # Where the columns of none begin beyond a screen does not matter.
    return of_neighbours(config, record, rays, [
        one for one in choose(random, rays, RAYS) if columns_near(record, *one)[0] < record.columns])


def borders(frustum, config):
    """Of a ray in each shell the window ends at the frustum's last column, one before it, or one behind it."""
    random = np.random.default_rng(7)
    record = frustum(random, config)
    rays_of, rays, chosen = shells(record), [], []
    for shell in range(2, 11):
        one = rays_of(shell)
        row, column = int(random.integers(one.rows)), int(random.integers(one.columns))
        end = (record.columns - 1 + shell % 3 << INDEX_FRACTION) - int(random.integers(1 << INDEX_FRACTION))
        away = end + (1 << INDEX_FRACTION - 1) - int(one.column_reach[row] + one.column_position[column])
        rays.append(replace(one, column_position=one.column_position + away))
        chosen.append((rays[-1], row, column, column))
    assert {(int(one.column_position[column] + one.column_reach[row]) + (1 << INDEX_FRACTION - 1) >> INDEX_FRACTION)
            - record.columns for one, row, column, _ in chosen} == {-1, 0, 1}
    return of_neighbours(config, record, rays, chosen)


def choose(random, rays, count):
    """A shell's rays, a row of them, and the first and the last of neighbours in it."""
    for _ in range(count):
        one = rays[int(random.integers(len(rays)))]
        row, column = int(random.integers(one.rows)), int(random.integers(one.columns))
        yield one, row, column, min(one.columns - 1, column + int(random.integers(GRID_GROUP)))


def columns_near(record, one, row, column, last):
    """The first column of neighbours, and how many."""
    half, reach = 1 << INDEX_FRACTION - 1, int(one.column_reach[row])
    first = (int(one.column_position[column]) - reach + half - 1) >> INDEX_FRACTION
    end = ((int(one.column_position[last]) + reach - half) >> INDEX_FRACTION) + 1
    if record.is_screen:
        first, end = max(first, 0), min(end, record.columns)
    count = max(0, min(end - first, record.columns))
    if count == record.columns:
        first = 0
    return first if record.is_screen else first % record.columns, count


def of_neighbours(config, record, rays, chosen):
    """``chosen``: what `choose` gives."""
    addresses, thresholds = GridAddresses(rays), {one.shell: 10 + 3 * one.shell for one in rays}
    items, expected = [], []
    for tag, (one, row, column, last) in enumerate(chosen):
        request = addresses.request(one, row * one.columns + column)
        items.append({"tag": tag, "last": request["column"] + last - column,
                      **{name: request[name] for name in ("shell", "row", "column")}})
        first, count = columns_near(record, one, row, column, last)
        expected.append({"tag": tag, "threshold": thresholds[one.shell], "window": {
            "column_first": first, "column_count": count, "row_first": one.first_row[row],
            "row_count": one.row_count[row]}})
    return Vectors(ports={"is_screen": int(record.is_screen), "columns": record.columns}, inputs={"i": items},
                   expected={"o": expected}, first={"i_table": grid_writes(rays, config, thresholds=thresholds)})


class TestNearWindow(Bench):
    component, arguments, simulators = NearWindow, {"tag": 9}, SLOW_IN_ICARUS
    variants = CONFIGURATIONS.values()
    cases = {f"{of.__name__}, {frustum.__name__}": partial(of, frustum)
             for of in (of_record, neighbours, far_neighbours, borders)
             for frustum in (random_hemisphere, random_screen)}
