"""The parameters of a frustum fit the machine's widths."""

from itertools import pairwise

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import BEGIN_BITS, INDEX_BITS, NEVER, POSITION_FRACTION
from golden.engine.ctu.grid_rays import FRACTION, INDEX_FRACTION
from golden.engine.ctu.unit import RAY_BYTES, SAMPLE, CellTraversalUnit, global_directions
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.lib.fixed import signed
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.g_coordinates import GCoordinates
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera

CONFIG = Config()
SCENE = builtin_scene("cornell")
COORDINATES = GCoordinates.of(SCENE, CONFIG.numbers)
TABLE = CellTable(COORDINATES.integers(SCENE.vertices), cell=COORDINATES.cell_size(0.0625))


def screen(fov, *, width=96, height=64):
    middle = COORDINATES.bounds.mean(axis=0)
    camera = Camera(eye=tuple(middle), target=tuple(middle + np.array([0.3, 1, 0.2])), fov=fov)
    return screen_record(Screen(camera=camera, width=width, height=height), COORDINATES)


RECORDS = {"hemisphere": lambda: hemisphere_record(Hemisphere(256, 64), COORDINATES, COORDINATES.bounds.mean(axis=0),
                                                   (1, 2, 3)),
           **{f"screen {fov}": lambda fov=fov: screen(fov) for fov in (0.1, 5, 53, 83, 90, 140, 170)},
           "line": lambda: screen(60, width=200, height=1)}


@pytest.mark.parametrize("kind", RECORDS)
def test_tables_directions_and_shells_fit_their_formats(kind):
    record = RECORDS[kind]()
    unit = CellTraversalUnit(record, TABLE)
    signed(INDEX_BITS - 1, POSITION_FRACTION).check(TABLE.position(record.origin), "place")
    begins = []
    for shell in range(2, min(unit.last_shell, 24) + 1):
        rays = unit.rays(shell)
        for name in "row_table", "column_table", "direction":
            signed(1, FRACTION).check(getattr(rays, name), name)
        signed(2, FRACTION).check(global_directions(rays.direction.reshape(-1, 3), record), "direction in G")
        for name in "row_position", "column_position", "column_border", "column_reach":
            signed(17, INDEX_FRACTION).check(getattr(rays, name), name)
        assert (np.diff(rays.row_position) >= 0).all()
        assert (np.diff(rays.column_position) >= 0).all()
        begin, end = unit.borders(shell)
        assert begin < 1 << BEGIN_BITS
        assert end - begin <= NEVER
        assert 1 <= unit.threshold(shell, CONFIG) <= CONFIG.icu.settle.high + 1
        begins.append((begin, end))
    assert all(end == begin for (_, end), (begin, _) in pairwise(begins))


def test_thresholds_fall_from_shell_to_shell():
    unit = CellTraversalUnit(RECORDS["hemisphere"](), TABLE)
    thresholds = [unit.threshold(shell, CONFIG) for shell in range(1, unit.last_shell + 1)]
    assert (np.diff(thresholds) <= 0).all()
    assert thresholds[0] == CONFIG.icu.settle.high + 1
    assert thresholds[-1] < 100


def test_a_view_too_wide_for_the_parameters_is_refused():
    with pytest.raises(InputError, match="use a narrower view or larger cells"):
        CellTraversalUnit(screen(179.99), TABLE)


def test_an_origin_whose_shells_exceed_the_memory_is_refused_in_one_line():
    """Before any shell is made. The estimate is the memory of the grid rays that the shells between have."""
    def unit(sizes, fov=None):
        origin = SCENE.bounds.mean(axis=0) - np.array([0, 0, sizes * SCENE.size])
        coordinates = GCoordinates.of(SCENE, CONFIG.numbers, [origin])
        table = CellTable(coordinates.integers(SCENE.vertices), cell=coordinates.cell_size(0.0625))
        camera = Camera(eye=tuple(origin), target=tuple(SCENE.bounds.mean(axis=0)), up=(0, 1, 0), fov=fov or 1)
        record = (screen_record(Screen(camera=camera, width=32, height=32), coordinates) if fov
                  else hemisphere_record(Hemisphere(16, 4), coordinates, origin, (0, 0, 1)))
        return CellTraversalUnit(record, table)

    near = unit(6)
    shells = 5.5 * 16
    shell = near.rays(round(shells)).direction.nbytes * RAY_BYTES / 24
    estimate = RAY_BYTES * near.rays(SAMPLE).rows * near.rays(SAMPLE).columns * (shells / SAMPLE)**2
    assert shell * 0.8 < estimate < shell * 1.2
    with pytest.raises(InputError, match=r"\A.*: [0-9]+ shells lie between .* need [0-9]+ GiB, .* larger cells.*\Z"):
        unit(60)
    # A narrow picture from there has few grid rays.
    assert unit(60, fov=1).last_shell > 59 * 16
