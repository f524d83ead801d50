"""Windows of frusta on the machine: finer rays around small patches, and rays behind mirrors and panes."""

from types import SimpleNamespace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.density import Density
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta
from golden.engine.config import PRESETS
from golden.light.form_factors import PatchRows
from golden.scene.camera import Camera
from golden.scene.open import open_scene
from radiosity.flow.simulator.machine_caster import MachineCaster
from radiosity.flow.simulator.simulated_machines import opened_machine
from radiosity.flow.simulator.simulation_config import simulation_config
from tb.golden.cast.mirrors import mirror_room, rays_behind
from tb.golden.cast.small_squares import check_small_squares
from tb.system.checked_machine import use_checked_machines
from tb.system.job_machine import CONFIGS, TWO_CLUSTERS


@TWO_CLUSTERS
def test_finer_rays_are_goldens(monkeypatch):
    """Hemispheres together, level by level, and of the finer ones windows alone."""
    use_checked_machines(monkeypatch)
    scene = open_scene("cornell")

    def rows(caster):
        return PatchRows(scene, caster, rays=(16, 4), density=Density(least=12, levels=2)).cast(np.arange(len(scene)))

    with opened_machine(CONFIGS[2], policy=None, latency=10) as machine:
        caster = MachineCaster(scene, machine, cell=0.5)
        matrix, row_sums, rays = rows(caster)
    expected, expected_sums, expected_rays = rows(NaiveFixedFrusta(scene))
    np.testing.assert_array_equal(matrix.toarray(), expected.toarray())
    np.testing.assert_array_equal(row_sums, expected_sums)
    np.testing.assert_array_equal(rays, expected_rays)
    assert caster.jobs == 3
    counts, count = caster.kinds["hemispheres"], len(scene)
    assert 2 * count < counts["frusta"] <= 3 * count
    # Of a tile some rays may be of cells that are not divided.
    assert rays.sum() < counts["rays"] < count * (64 + 256 + 1024)


@TWO_CLUSTERS
@pytest.mark.parametrize("is_mirrored", [True, False])
def test_rays_behind_planes_are_goldens(monkeypatch, is_mirrored):
    use_checked_machines(monkeypatch)
    scene, size = mirror_room(), (64, 40)
    x = -0.9 if is_mirrored else 1.1
    camera = Camera(eye=(x, -0.6, 1.4), target=(x, 2.5, 1.3), up=(0, 0, 1), fov=70)
    rays, field = rays_behind(scene, camera, size, is_mirrored=is_mirrored)
    screen = Screen(camera=camera, width=size[0], height=size[1])

    def behind(caster):
        specular = caster.specular(screen, 1)
        return specular, *specular.nearest(rays, field, is_mirrored=is_mirrored)

    _, expected_rows, expected = behind(NaiveFixedFrusta(scene))
    with opened_machine(CONFIGS[2], policy=None, latency=10) as machine:
        caster = MachineCaster(scene, machine, cell=0.5)
        specular, rows, hits = behind(caster)
    np.testing.assert_array_equal(rows, expected_rows)
    for name in "patch", "t", "u", "v":
        np.testing.assert_array_equal(getattr(hits, name), getattr(expected, name))
    assert caster.specular_rays == specular.rays == len(rows) > 400
    counts = caster.kinds["specular frusta"]
    assert counts["frusta"] == 1
    # Whole tiles, and not the whole screen.
    assert len(rows) <= counts["rays"] < len(screen)


@pytest.mark.parametrize(("preset", "why"), [
    ("small", r"grids of up to 4096 x 2048, which need an icu\.side_bits of 12, not 10"),
    ("thesis", r"without lists of subshells \(ctu\.subshell_bits\), not \d+")])
def test_machines_that_cannot_are_refused(preset, why):
    caster = MachineCaster(open_scene("tetra:1"), SimpleNamespace(config=PRESETS[preset]), cell=0.5)
    with pytest.raises(InputError, match=why):
        caster.dense_hemispheres(Density(least=1), Hemisphere(64, 32), np.zeros((1, 3)), np.eye(3)[None], [-1])


def test_machines_with_subshell_lists_cast_whole_screens(monkeypatch):
    requested = []

    def cast(records):
        requested.extend(records)
        return [(np.arange(len(record)), *np.zeros((2, len(record)), dtype=np.int64)) for record in records]

    monkeypatch.setattr(MachineCaster, "_machine", lambda caster, geometry: cast)
    scene = open_scene("tetra:1")
    caster = MachineCaster(scene, SimpleNamespace(config=PRESETS["thesis"]), cell=0.5)
    screen = Screen(camera=Camera(eye=scene.vertices.mean(axis=(0, 1)), target=scene.vertices[0, 0], up=(1, 2, 3)),
                    width=16, height=8)
    patch, _, _ = caster.beyond(np.arange(3), screen, np.array([5, 100]))
    assert patch.tolist() == [5, 100]
    assert [len(record) for record in requested] == [128]


@pytest.mark.nightly
def test_small_squares_have_their_form_factors():
    config = simulation_config(PRESETS["tiny"].replace({"icu.side_bits": 12}), clusters=1, topology=None)
    with opened_machine(config, policy=None, latency=10) as machine:
        check_small_squares(lambda scene: MachineCaster(scene, machine, cell=0.5), 100)
