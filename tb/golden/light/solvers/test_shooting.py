import numpy as np
import pytest

from golden.light.solvers import RadiositySystem
from golden.light.solvers.shooting import ambient_overshooting, progressive_refinement, proximity_refinement
from tb.golden.light.solvers.systems import CUTS, duct, exact, furnace, lit_cube


def test_the_first_shot_gives_the_direct_light():
    direct = progressive_refinement(duct(), max_steps=2).radiosity[:, 0]
    # rho_j E_i F_ij A_i / A_j
    np.testing.assert_allclose(direct, (1, 0.8 * (1 / 3) * 3 / 4, 0.2 * (2 / 3) * 3 / 5), rtol=0, atol=1e-15)


def test_progressive_refinement_only_ever_adds_light():
    system, last = lit_cube("analytic"), 0
    for steps in (1, 5, 20, 80, 320):
        radiosity = progressive_refinement(system, max_steps=steps).radiosity
        assert (radiosity >= last).all()
        last = radiosity
    assert (last <= exact(system) + 1e-12).all()


def test_the_ambient_term_brings_an_early_picture_nearer():
    system = lit_cube("analytic")
    truth = exact(system)
    early = progressive_refinement(system, max_steps=CUTS**2 + 1)
    assert np.abs(early.display - truth).mean() < 0.2 * np.abs(early.radiosity - truth).mean()


def test_overshooting_takes_fewer_shots():
    for system in (furnace(0.5), lit_cube("analytic")):
        assert ambient_overshooting(system).steps < 0.8 * progressive_refinement(system).steps


def test_overshooting_converges_where_areas_and_openings_deceive_it():
    generator = np.random.default_rng(37)
    for _ in range(15):
        count = int(generator.integers(20, 80))
        area = np.exp(3 * generator.normal(size=count))
        exchange = np.triu(generator.random((count, count)) * (generator.random((count, count)) < 0.5), 1)
        exchange += exchange.T
        factors = exchange / area[:, None] / (exchange.sum(axis=1) / area).max()
        system = RadiositySystem(form_factors=factors, reflectance=generator.random((count, 3)), area=area,
                                 emission=generator.random((count, 3)) * (generator.random((count, 1)) < 0.2) + 1e-3)
        solution = ambient_overshooting(system)
        assert solution.converged
        np.testing.assert_allclose(solution.radiosity, exact(system), rtol=0, atol=1e-4)


class Watched(RadiositySystem):
    """Remembers which patches shot together."""

    def columns(self, patches):
        self.groups = [*getattr(self, "groups", []), patches]
        return super().columns(patches)


@pytest.fixture
def watched():
    system = lit_cube("analytic")
    return Watched(form_factors=system.matrix, reflectance=system.reflectance, emission=system.emission,
                   area=system.area, centre=system.centre, normal=system.normal)


def test_proximity_shoots_from_near_patches_with_similar_normals(watched):
    steps = proximity_refinement(watched, group=6).steps
    assert len(watched.groups) == steps - 1
    sizes = [len(group) for group in watched.groups]
    assert max(sizes) == 6
    assert np.mean(sizes) > 4
    for group in watched.groups:
        assert len(np.unique(group)) == len(group)
        assert (watched.normal[group] @ watched.normal[group[0]] >= np.cos(np.radians(30)) - 1e-12).all()
    # Only the ceiling shines at first, and the sixth nearest of a grid is no farther than a knight's move in a corner.
    spread = np.linalg.norm(watched.centre[watched.groups[0]] - watched.centre[watched.groups[0][0]], axis=1)
    assert spread.max() <= np.sqrt(5) / CUTS + 1e-12


def test_proximity_takes_far_fewer_steps_and_little_more_work(watched):
    alone = progressive_refinement(lit_cube("analytic"))
    together = proximity_refinement(watched, group=8)
    assert together.steps < alone.steps / 4
    assert sum(len(group) for group in watched.groups) < 1.3 * alone.steps
