"""The choice of the cell size, and the counts and the model that it rests on."""

from itertools import product

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.default_camera import default_camera
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS, Config
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.icu.section_clip import SectionWindow
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.phase_request import phase_request
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.cell_choice import CELLS, LIST_CELLS, choose_cell
from golden.engine.schedule.cycle_model import CELLS as WAITING
from golden.engine.schedule.cycle_model import END, FETCH, PATCH, SETUP, START, CycleModel, StageWork
from golden.engine.schedule.square_scan import FEW, GROUP, SIDE, scanned_words
from golden.scene.open import open_scene
from hw.ctu.ctu_formats import GRID_GROUP
from hw.ctu.square_scan import SIDE_BITS
from hw.ctu.survival import FEW as MACHINES_FEW

CONFIG = Config()


def test_groups_and_words_are_the_machines():
    assert (GROUP, FEW, SIDE) == (GRID_GROUP, MACHINES_FEW, 1 << SIDE_BITS)


def words_of(window, live, side):
    """One window, word by word and square by square."""
    columns, wrapped = range(window[0], window[0] + window[1]), range(window[2])
    rows = range(window[3], sum(window[3:]))
    if not rows:
        return 1, False
    pieces = [sorted({column // side for column in piece}) for piece in (columns, wrapped)]
    height, read = sorted({row // side for row in rows}), 0
    for row in sorted({one // SIDE for one in height}):
        for piece in pieces:
            for word in sorted({column // SIDE for column in piece}):
                read += 1
                if any(live[square] for square in product(height, piece)
                       if (square[0] // SIDE, square[1] // SIDE) == (row, word)):
                    return read, True
    return read, False


def test_words_are_read_until_the_first_live_square():
    random, side, squares = np.random.default_rng(1), 2, (11, 13)
    windows = []
    for _ in range(400):
        first, row = random.integers(26), random.integers(22)
        across, down = random.integers(1, 27 - first), random.integers(0, 23 - row)
        wrapped = random.integers(first + 1) if first + across == 26 else 0
        windows.append((first, across, wrapped, row, down) if down else (0, 0, 0, 0, 0))
    given = SectionWindow(*np.array(windows, dtype=np.int64).T)
    for share in 0, 0.01, 0.1, 1:
        live = random.random(squares) < share
        words, alive = scanned_words(given, live, side)
        assert list(zip(words.tolist(), alive.tolist(), strict=True)) == [
            words_of(tuple(map(int, one)), live, side) for one in windows]


def work(shell, *tests, cells=1, words=0):
    return StageWork(shell=shell, cells=cells, words=words, tests=np.array(tests, dtype=np.int64))


def cycles_of(config, *stages, patches=1):
    model = CycleModel(config, patches=patches)
    for one in stages:
        model.add(one)
    return model.cycles


def test_servers_overlap_and_wait():
    assert cycles_of(CONFIG) == START + END
    # One cell, then setup, then the tests one by one.
    assert cycles_of(CONFIG, work(1, 1000)) == START + 1 + SETUP + 1000 + END
    assert cycles_of(CONFIG, work(1, 1000, 500)) == START + 1 + SETUP + 1500 + END
    # Patches without tests take a place in the line, and their fetches take longer than their cycle of tests.
    count = CONFIG.memsys.own_patches
    assert cycles_of(CONFIG, work(1, *[0] * 60), patches=60) == START + 1 + 59 * PATCH + SETUP + 1 + END
    mixed = 59 * (PATCH + FETCH) // 2
    assert cycles_of(CONFIG, work(1, *[0] * 60), patches=2 * count) == START + 1 + mixed + SETUP + 1 + END
    # A slot is free when its patch has been tested.
    slots = CONFIG.icu.slots
    full = work(1, *[2000] + [0] * slots)
    assert cycles_of(CONFIG, full, patches=slots) == START + 1 + SETUP + 2000 + SETUP + 1 + END


def test_survival_of_old_codes_is_short():
    """Before any test has ended all rays are alive; later all words of dead ones are read."""
    first = work(1, 5000)
    assert cycles_of(CONFIG, first, work(2, words=3000)) == cycles_of(CONFIG, first)
    barrier = CONFIG.replace({"ctu.run_ahead": 0})
    dead = cycles_of(barrier, first, work(2), work(3, words=3000))
    assert dead == cycles_of(CONFIG, first) + 3000


def test_traversal_waits_behind_its_cells():
    """The patch of the first cell keeps all slots, so that of a later one waits, and further cells with it."""
    slots = CONFIG.icu.slots
    full = work(1, *[3000] + [1] * slots)
    few, many = (cycles_of(CONFIG, full, work(2, cells=count), work(3, 0), patches=slots)
                 for count in (WAITING - 2, 3 * WAITING))
    assert few < many


@pytest.fixture(scope="module")
def cornell():
    scene = open_scene("cornell")
    points, down = ceiling_points(scene)
    camera = scene.camera or default_camera(scene)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [*points, camera.eye])
    hemispheres = [hemisphere_record(Hemisphere(64, 16), geometry.coordinates, points[number], down)
                   for number in (0, 5)]
    return geometry, [*hemispheres, screen_record(Screen(camera=camera, width=40, height=30), geometry.coordinates)]


@pytest.mark.parametrize("which", [
    slice(1), pytest.param(slice(2), marks=pytest.mark.nightly), slice(2, 3)], ids=["hemisphere", "two", "screen"])
def test_the_least_prediction_is_chosen(cornell, which):
    geometry, records = cornell
    chosen = choose_cell(records[which], geometry, CONFIG)
    assert set(chosen.cycles) == set(CELLS)
    assert chosen.cycles[chosen.cell] == min(chosen.cycles.values())
    # Alone, a candidate is predicted to its end.
    alone = {cell: choose_cell(records[which], geometry, CONFIG, candidates=[cell]).cycles[cell] for cell in CELLS}
    assert min(alone, key=alone.get) == chosen.cell
    assert all(chosen.cycles[cell] <= alone[cell] for cell in CELLS)


def test_sections_may_have_more_rays_together_than_one_cluster(cornell):
    geometry, records = cornell
    tiny = CONFIG.replace({"icu.rays": 64})
    assert choose_cell(records[:1], geometry, tiny).cell == choose_cell(records[:1], geometry, CONFIG).cell


@pytest.mark.parametrize("changes", [
    {"memsys.scene_cells": 128, "memsys.own_cells": 128}, {"ctu.shell_bits": 3}, {"ctu.grid_row_bits": 6},
    {"ctu.grid_column_bits": 7}], ids=lambda changes: min(changes))
def test_cells_that_do_not_fit_are_no_candidates(cornell, changes):
    """The smallest cells among the candidates fit; smaller ones would not."""
    geometry, records = cornell
    config = CONFIG.replace({"noc.columns": 1, "noc.rows": 1, **changes})
    cell = min(choose_cell(records, geometry, config).cycles)
    assert cell > min(CELLS)
    table = Shelling(geometry, config, cell=cell).table
    for record in records:
        plan_job([phase_request([record], geometry, table, config, ratio=16)], config)


def test_a_machine_too_small_for_any_cells_is_refused_by_what_the_largest_need(cornell):
    geometry, records = cornell
    messages = []
    for candidates in ([0.1], [0.0625], [0.1, 0.0625], [0.0625, 0.1]):
        with pytest.raises(InputError, match="Shells must be at most 8") as caught:
            choose_cell(records, geometry, CONFIG.replace({"ctu.shell_bits": 3}), candidates=candidates)
        messages.append(str(caught.value))
    assert messages[0] != messages[1]
    assert messages[2] == messages[3] == messages[0]


def test_the_thesis_machine_has_its_own_cells(cornell):
    geometry, records = cornell
    assert set(choose_cell(records[:1], geometry, PRESETS["thesis"]).cycles) == set(LIST_CELLS)
