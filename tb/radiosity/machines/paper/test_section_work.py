"""The work of a section is golden's, divided among subshells."""

from functools import lru_cache

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import hemisphere_record
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.scene.open import open_scene
from radiosity.machines.paper.mean_window import MeanWindow
from radiosity.machines.paper.section_work import SectionCasting

CONFIG, COLUMNS, ROWS = PRESETS["paper"], 64, 16
SECTIONS = (Sector(0, 40, 0, 16), Sector(40, 64, 0, 16))
SECTORS = ((Sector(0, 40, 0, 7), Sector(0, 40, 7, 16)), (SECTIONS[1],))


@lru_cache
def scene(name="lobby", cell=0.1):
    opened = open_scene(name)
    points, down = ceiling_points(opened)
    geometry = PatchGeometry.of(opened, CONFIG.numbers, points[[5]])
    record = hemisphere_record(Hemisphere(COLUMNS, ROWS), geometry.coordinates, points[5], down)
    return Shelling(geometry, CONFIG, cell=cell), record


@lru_cache
def cast(name="lobby"):
    shelling, record = scene(name)
    memory = RayMemory(len(record), CONFIG)
    tests = shelling.tests(record, memory)
    works = [SectionCasting(shelling, record, CONFIG, tests=tests, memory=memory, section=section,
                            sectors=sectors).run() for section, sectors in zip(SECTIONS, SECTORS, strict=True)]
    return works, memory, tests


@pytest.mark.parametrize("name", ["lobby", "cornell"])
def test_hits_are_golden_s(name):
    shelling, record = scene(name)
    _, memory, _ = cast(name)
    hits, _ = shelling.cast(record)
    assert np.array_equal(memory.inverse, hits.inverse)
    assert np.array_equal(memory.patch, hits.patch)


def test_patches_are_those_of_golden_s_clusters():
    shelling, record = scene()
    works, _, _ = cast()
    _, counts = shelling.cast(record, SECTIONS)
    assert [work.patches for work in works[1:]] == [counts[1].patches]
    found = [[patch.patch for one in work.subshells for patch in one.patches] for work in works]
    assert all(len(set(each)) == len(each) for each in found)


def test_subshells_are_as_large_as_the_mean_window_two_shells_before():
    works, _, tests = cast()
    for work in works:
        mean, sizes = MeanWindow(), []
        for shell in range(1, len(work.extents) + 1):
            sizes.append(mean.extents)
            patches = [patch.patch for one in work.subshells if one.shell == shell for patch in one.patches]
            mean.add(tests.patches.window[np.array(patches, dtype=np.int64)])
        assert work.extents[:2] == ((COLUMNS, ROWS),) * 2
        assert work.extents[2:] == tuple(sizes[1:-1])
        assert work.extents[-1] < (COLUMNS, ROWS)


def test_rays_that_have_hit_are_not_tested_again():
    """The hit counts once the shell has ended: another patch of the same shell may be nearer."""
    works, _, tests = cast()
    windows = tests.patches.window
    for work, section in zip(works, SECTIONS, strict=True):
        in_windows = tested = 0
        for one in work.subshells:
            for patch in one.patches:
                window = windows[np.array([patch.patch])]
                _, column, _ = window.pairs(COLUMNS)
                assert patch.rays == ((column >= section.first_column) & (column < section.end_column)).sum()
                assert sum(count for _, count in patch.tests) <= patch.rays
                if one.shell <= 2:
                    assert sum(count for _, count in patch.tests) == patch.rays
                in_windows += patch.rays
                tested += sum(count for _, count in patch.tests)
        assert tested == work.tests
        assert tested < in_windows


def test_tests_belong_to_subshells_of_the_same_shell():
    works, _, _ = cast()
    for work in works:
        for one in work.subshells:
            assert all(work.subshells[where].shell == one.shell for patch in one.patches for where, _ in patch.tests)


def test_needs_are_subshells_of_the_shell_before_in_the_sector():
    works, _, _ = cast()
    for work in works:
        for one in work.subshells:
            assert (len(one.needs) > 0) == (one.shell > 1)
            assert all((work.subshells[needed].shell, work.subshells[needed].sector) == (one.shell - 1, one.sector)
                       for needed in one.needs)
    # A wavefront: late subshells need few of many.
    last = [one for one in works[0].subshells if one.shell == len(works[0].extents)]
    before = sum(one.shell == len(works[0].extents) - 1 and one.sector == last[0].sector for one in works[0].subshells)
    assert min(len(one.needs) for one in last) < before


def test_steps_and_grid_rays_are_those_of_golden_s_traversal():
    """Of the section that is one sector; golden's clusters skip a test, so survival differs by few rays."""
    shelling, record = scene()
    works, _, _ = cast()
    _, counts = shelling.cast(record, SECTIONS)
    near = sum(one.steps for one in works[1].subshells if one.shell == 1)
    assert works[1].steps - near == counts[1].passes
    assert sum(one.scanned for one in works[1].subshells) == counts[1].scanned
