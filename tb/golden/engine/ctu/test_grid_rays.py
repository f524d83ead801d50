"""Every cell of a shell is met by a grid ray, which survives while an intersection ray near it may change."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from golden.cast.hemisphere import Hemisphere
from golden.engine.config import Config
from golden.engine.ctu import margins
from golden.engine.ctu.grid_rays import FRACTION, hemisphere_rays, screen_rays
from golden.engine.ctu.sector import Sector
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors, survivors_by_code
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.g_coordinates import GCoordinates
from golden.scene.builtin import builtin_scene

CONFIG = Config()
SHELLS = [2, 3, 4, 7, 13, 30]
AZIMUTHS, POLARS = 64, 16
SCREEN = {"pixels": (50, 31), "bits": (6, 5), "half_angles": (0.9, 0.45)}
SCALE = 1.125


@pytest.mark.parametrize("shell", SHELLS)
def test_every_centre_in_a_shell_is_within_half_a_cell_of_a_grid_ray_at_its_own_distance(shell):
    random = np.random.default_rng(shell)
    below = np.sin(margins.horizon(shell))
    centre = random.normal(size=(1500, 3))
    centre /= np.linalg.norm(centre, axis=1, keepdims=True)
    centre = centre[centre[:, 2] >= -below]
    rays = hemisphere_rays(shell, AZIMUTHS, POLARS).direction.reshape(-1, 3) / 2.0**FRACTION
    # The chord between unit vectors, to the nearest ray of each.
    assert (shell * cKDTree(rays).query(centre)[0]).max() < margins.RADIUS


@pytest.mark.parametrize("shell", SHELLS)
def test_every_centre_in_a_slab_is_within_half_a_cell_of_a_grid_ray_at_its_own_depth(shell):
    random = np.random.default_rng(shell)
    rays = screen_rays(shell, **SCREEN).direction.reshape(-1, 3)[:, :2] / 2.0**FRACTION * SCALE
    half = np.array(SCREEN["half_angles"]) * SCREEN["pixels"] / 2.0**np.array(SCREEN["bits"])
    edge = half + margins.screen_border(shell, half, SCALE)
    centre = random.uniform(-edge, edge, (1000, 2))
    assert (shell * cKDTree(rays).query(centre)[0]).max() < margins.RADIUS


@pytest.mark.parametrize("shell", SHELLS)
def test_codes_let_survive_what_distances_do_and_what_shares_a_square_with_it(shell):
    coordinates = GCoordinates.of(builtin_scene("cornell"), CONFIG.numbers)
    record = hemisphere_record(Hemisphere(AZIMUTHS, POLARS), coordinates, coordinates.bounds.mean(axis=0), (0, 0, 1))
    rays, random = hemisphere_rays(shell, AZIMUTHS, POLARS), np.random.default_rng(shell)
    for section in (Sector.whole(record), Sector(5, 40, 3, 16), Sector(50, 64, 0, 9)):
        codes = random.integers(0, 40, (section.end_row - section.first_row, section.end_column - section.first_column))
        codes[random.random(codes.shape) < 0.98] = 200
        squares = np.zeros((POLARS, AZIMUTHS), dtype=bool)
        for row, column in np.argwhere(codes < 30) // 4 * 4:
            squares[section.first_row + row:, section.first_column + column:][:4, :4] = True
        squares &= section.mask(record)
        coded = survivors_by_code(rays, SettlePyramid(codes, CONFIG), 30, section, record)
        assert (coded == survivors(rays, squares)).all()
        assert not survivors_by_code(rays, SettlePyramid(codes, CONFIG), 0, section, record).any()
