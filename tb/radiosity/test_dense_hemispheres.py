"""Finer rays around small patches on the machine: those of golden, with the closed forms' factors."""

from types import SimpleNamespace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.density import Density
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta
from golden.engine.config import PRESETS
from golden.light.form_factors import PatchRows
from golden.scene.open import open_scene
from radiosity.flow.simulator.machine_caster import MachineCaster
from radiosity.flow.simulator.simulated_machines import opened_machine
from radiosity.flow.simulator.simulation_config import simulation_config
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


@pytest.mark.parametrize(("preset", "why"), [
    ("small", r"grids of up to 4096 x 2048, which need an icu\.side_bits of 12, not 10"),
    ("thesis", r"without lists of subshells \(ctu\.subshell_bits\), not \d+")])
def test_machines_that_cannot_are_refused(preset, why):
    caster = MachineCaster(open_scene("tetra:1"), SimpleNamespace(config=PRESETS[preset]), cell=0.5)
    with pytest.raises(InputError, match=why):
        caster.dense_hemispheres(Density(least=1), Hemisphere(64, 32), np.zeros((1, 3)), np.eye(3)[None], [-1])


@pytest.mark.nightly
def test_small_squares_have_their_form_factors():
    config = simulation_config(PRESETS["tiny"].replace({"icu.side_bits": 12}), clusters=1, topology=None)
    with opened_machine(config, policy=None, latency=10) as machine:
        check_small_squares(lambda scene: MachineCaster(scene, machine, cell=0.5), 100)
