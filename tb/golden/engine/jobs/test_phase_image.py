"""The image of a phase: its tables serve every frustum of the phase."""

from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import PRESETS
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.jobs.load_regions import LOADED_REGIONS, PHASE, SCENE, region_bits
from golden.engine.memory_map import REGIONS, MemoryImage, from_bytes, phase_image
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.phase import schedule
from golden.scene.builtin import builtin_scene
from golden.scene.halve import halved
from golden.scene.open import open_scene
from tb.golden.engine.schedule.scenes import CONFIG, case

RAYS = Hemisphere(64, 16)
# Shells from a corner are about twice those from the middle.
SHARES = np.array([[0.5, 0.5, 0.5], [0.02, 0.03, 0.98], [0.9, 0.4, 0.1], [0.5, 0.1, 0.9]])


@pytest.fixture(scope="module")
def scene():
    return case("lobby", rays=(RAYS.azimuths, RAYS.polars))


@pytest.fixture(scope="module")
def hemispheres(scene):
    lower, upper = open_scene("lobby").bounds
    return [hemisphere_record(RAYS, scene.geometry.coordinates, lower + (upper - lower) * share, share - 0.4, source=k)
            for k, share in enumerate(SHARES)]


@pytest.fixture(scope="module")
def screens(scene):
    lower, upper = open_scene("lobby").bounds
    camera = open_scene("lobby").camera
    return [screen_record(Screen(camera=replace(camera, eye=tuple(lower + (upper - lower) * share)), width=50,
                                 height=40), scene.geometry.coordinates) for share in SHARES]


@pytest.fixture(scope="module", params=["hemispheres", "screens"])
def phase(request, scene):
    records = request.getfixturevalue(request.param)
    weights = RAYS.polar_weights if request.param == "hemispheres" else None
    return records, weights, phase_image(records, scene.geometry, scene.shelling.table, CONFIG, weights=weights)


def test_tables_of_every_frustum_begin_those_of_the_phase(scene, phase):
    records, weights, image = phase
    table, shells = scene.shelling.table, set()
    for record in records:
        own = phase_image([record], scene.geometry, table, CONFIG, weights=weights)
        for name in "columns", "rows", "cell_grid", "cells", "patch_lists":
            assert np.array_equal(image[name], own[name])
        for name in "shells", "grid_rows", "grid_columns":
            assert np.array_equal(image[name][:len(own[name])], own[name]), name
        shells.add(len(own["shells"]))
    assert len(shells) > 1, "frusta with other last shells"
    assert len(image["shells"]) == max(shells)
    assert image.last_shell == max(CellTraversalUnit(record, table).last_shell for record in records)


def test_patches_have_a_kind(scene, phase):
    image = phase[2]
    assert image["patches"].dtype.fields["kind"][1] == 13
    assert not image["patches"]["kind"].any()
    assert np.array_equal(image.vertices(), scene.geometry.vertices)


def test_every_cluster_holds_all_patches_and_cluster_0_lists_them(scene, phase):
    image, patches = phase[2], len(scene.geometry)
    assert (image["residence"]["cluster"] == -2).all()
    assert image["residence"]["address"].tolist() == list(range(patches))
    assert image.residents(0).tolist() == list(range(patches))
    assert image["clusters"]["residents"].tolist() == [patches, 0, 0, 0]
    assert image["clusters"]["processor"].tolist() == [0, 1, 2, 3]
    assert not image["clusters"]["subshells"].any()


@pytest.mark.parametrize("less", [1, 3])
def test_the_clusters_share_a_scene_larger_than_the_memory_of_each(scene, hemispheres, less):
    """Patch after patch in the next cluster; what is left when all are full stays in main memory."""
    patches, clusters = len(scene.geometry), CONFIG.noc.nodes
    capacity = 1 << (patches - 1).bit_length() - less
    config = CONFIG.replace({"memsys.own_patches": capacity})
    image = phase_image(hemispheres[:1], scene.geometry, scene.shelling.table, config)
    held = min(patches, clusters * capacity)
    assert (held < patches) == (less == 3)
    residence = list(zip(image["residence"]["cluster"].tolist(), image["residence"]["address"].tolist(), strict=True))
    assert residence[:held] == [(patch % clusters, patch // clusters) for patch in range(held)]
    assert set(residence[held:]) <= {(-1, -1)}
    for number in range(clusters):
        assert image.residents(number).tolist() == list(range(number, held, clusters))
    assert image["clusters"]["residents"].max() <= capacity


@pytest.mark.parametrize(("patches", "everywhere"), [(256, True), (257, False)])
def test_a_scene_of_just_the_memory_of_each_cluster_is_held_by_all(patches, everywhere):
    scene = halved(builtin_scene("lobby"), patches)
    geometry = PatchGeometry.of(scene, CONFIG.numbers)
    table = CellTable(geometry.vertices, cell=geometry.coordinates.cell_size(1 / 8))
    record = hemisphere_record(RAYS, geometry.coordinates, scene.bounds.mean(axis=0), (0, 0, -1))
    image = phase_image([record], geometry, table, CONFIG.replace({"memsys.own_patches": 256}))
    assert (image["residence"]["cluster"] == -2).all() == everywhere
    assert image["clusters"]["residents"].tolist() == ([256, 0, 0, 0] if everywhere else [65, 64, 64, 64])


def test_a_schedule_gives_each_cluster_its_own_residents_and_subshells(scene, hemispheres):
    table = scene.shelling.table
    plan = schedule(hemispheres[0], scene.geometry, table, CONFIG, clusters=4, ratio=16, capacity=20)
    image = from_bytes(
        phase_image(hemispheres, scene.geometry, table, PRESETS["thesis"], plan=plan).to_bytes())
    assert any(len(listed) for listed in plan.subshells)
    cluster, address = plan.sets.residence(len(scene.geometry))
    assert np.array_equal(image["residence"]["cluster"], cluster)
    assert np.array_equal(image["residence"]["address"], address)
    for number, (held, listed) in enumerate(zip(plan.sets.patches, plan.subshells, strict=True)):
        assert np.array_equal(image.residents(number), held)
        assert np.array_equal(image.subshells(number), np.stack([listed.patches, listed.shell], axis=1))


def test_tables_of_cluster_0_are_for_all_unless_a_cluster_has_its_own(scene, hemispheres):
    table = scene.shelling.table
    assert phase_image(hemispheres[:1], scene.geometry, table, CONFIG).has_copies
    assert not phase_image(hemispheres[:1], scene.geometry, table,
                           CONFIG.replace({"memsys.own_patches": 16})).has_copies
    plan = schedule(hemispheres[0], scene.geometry, table, CONFIG, clusters=4, ratio=16, capacity=20)
    image = phase_image(hemispheres[:1], scene.geometry, table, PRESETS["thesis"], plan=plan)
    assert not image.has_copies
    # Each of the two reasons alone.
    alone = np.full_like(image["residence"]["cluster"], -1)
    residence = image["residence"].copy()
    residence["cluster"] = alone
    assert not MemoryImage({**image.regions, "residence": residence}).has_copies
    assert not MemoryImage({**image.regions, "subshells": image["subshells"][:0]}).has_copies
    assert MemoryImage({**image.regions, "residence": residence, "subshells": image["subshells"][:0]}).has_copies


def test_frusta_of_other_rays_are_no_phase(scene, hemispheres, screens):
    coordinates = scene.geometry.coordinates
    other = hemisphere_record(Hemisphere(64, 32), coordinates, [0.1, 0.1, 0.1], [0, 0, 1])
    for records, wrong in (([*hemispheres[:2], other], 2), ([hemispheres[0], screens[0]], 1)):
        with pytest.raises(InputError, match=f"same rays; frustum {wrong} has others"):
            phase_image(records, scene.geometry, scene.shelling.table, CONFIG)


def broken(image, **changes):
    regions = {name: records.copy() for name, records in image.regions.items()}
    for target, value in changes.items():
        region, field = target.split("__")
        regions[region][field][1] = value
    return MemoryImage(regions).to_bytes()


@pytest.mark.parametrize(("change", "message"), [
    ({"patches__kind": 1}, r"patches\.kind must be 0"),
    ({"patches__vertex": 0, "patches__top": 0}, r"patches\.vertex must not be 0"),
    ({"residence__cluster": -3}, r"residence\.cluster must be -2 to 3"),
    ({"residence__cluster": 4}, r"residence\.cluster must be -2 to 3"),
    ({"residence__address": 2}, r"residence\.address of a copy"),
    ({"residence__address": -1}, r"residence\.address of a copy"),
    ({"residence__address": 1 << 20}, r"residence\.address of a copy")])
def test_broken_tables_are_refused(phase, change, message):
    with pytest.raises(InputError, match=f"memory image: {message}"):
        from_bytes(broken(phase[2], **change))


def test_bits_of_loads_are_in_the_order_of_the_regions():
    assert [region.name for region in REGIONS] == [
        "cell_grid", "cells", "patch_lists", "patches", "residence", "clusters", "subshells", "residents", "columns",
        "rows", "shells", "grid_rows", "grid_columns"]
    assert region_bits("patches", "grid_columns") == 1 << 3 | 1 << 12
    assert SCENE == 0b111
    assert PHASE == 0b1111101111000
    assert LOADED_REGIONS == 0x1FFF & ~(1 << 7)
    assert {region.life for region in REGIONS} == {"scene", "phase"}
