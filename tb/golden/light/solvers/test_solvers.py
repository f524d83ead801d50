"""What every solver must do."""

import numpy as np
import pytest
from scipy import sparse

from golden.light.solvers import SOLVERS, TOLERANCE, RadiositySystem
from tb.golden.light.solvers.systems import (
    CUTS,
    DUCT_FACTORS,
    DUCT_RADIOSITY,
    duct,
    exact,
    furnace,
    lit_cube,
    random_system,
)

every_solver = pytest.mark.parametrize("solve", SOLVERS.values(), ids=SOLVERS.keys())


def test_the_command_line_knows_seven_solvers():
    assert list(SOLVERS) == ["gauss-jacobi", "gauss-seidel", "over-relaxation", "progressive", "overshooting",
                             "proximity", "conjugate-gradient"]


@every_solver
def test_duct(solve):
    solution = solve(duct(), tolerance=1e-9)
    assert solution.converged
    np.testing.assert_allclose(solution.radiosity, np.outer(DUCT_RADIOSITY, (1, 0.5, 0)), rtol=0, atol=6e-9)


@every_solver
def test_furnace_reaches_its_temperature_everywhere(solve):
    solution = solve(furnace(0.8), tolerance=1e-4)
    assert solution.converged
    np.testing.assert_allclose(solution.radiosity, 1 / (1 - 0.8), rtol=1e-3)
    # The history ends at the first error below the tolerance.
    assert solution.errors.shape == (solution.steps, 3)
    assert (solution.errors[-1] < 1e-4).all()
    assert (solution.errors[:-1] >= 1e-4).any(axis=1).all()


@every_solver
def test_lit_cube_has_the_path_traced_light_on_floor_and_walls(solve):
    system = lit_cube("cast")
    radiosity = solve(system).radiosity
    incident = system.matrix @ radiosity
    faces = incident.reshape(6, CUTS**2, 3).mean(axis=1)
    np.testing.assert_allclose(faces[0], 0.3107, rtol=5e-3)
    np.testing.assert_allclose(faces[2:], 0.3283, rtol=5e-3)
    # The ceiling is black and sends what it emits.
    np.testing.assert_allclose(radiosity[CUTS**2:2 * CUTS**2], 1, rtol=0, atol=2e-6)


@every_solver
@pytest.mark.parametrize("seed", range(2))
def test_random_systems_are_solved(solve, seed):
    system = random_system(np.random.default_rng(seed))
    solution, truth = solve(system), exact(system)
    assert solution.converged
    # The error is at most the residual times the norm of the inverse, which reflectances of 0.99 let reach 100.
    assert (np.abs(solution.radiosity - truth).max(axis=0) <= 100 * TOLERANCE * truth.max(axis=0)).all()


@every_solver
def test_sparse_form_factors_give_the_same_steps(solve):
    dense, thin = solve(duct()), solve(duct(sparse.coo_array(DUCT_FACTORS)))
    np.testing.assert_allclose(thin.errors, dense.errors, rtol=1e-12, atol=1e-15)


@every_solver
def test_a_capped_run_says_that_it_has_not_converged(solve):
    for steps in (1, 2, 5):
        solution = solve(lit_cube("analytic"), tolerance=1e-12, max_steps=steps)
        assert not solution.converged
        assert solution.steps == steps
        assert np.isfinite(solution.display).all()


@every_solver
def test_darkness_stays_dark(solve):
    dark = RadiositySystem(form_factors=DUCT_FACTORS, reflectance=np.full((3, 3), 0.5), emission=np.zeros((3, 3)),
                           area=(3, 4, 5), centre=np.eye(3), normal=np.eye(3))
    solution = solve(dark)
    assert solution.converged
    assert (solution.display == 0).all()


@every_solver
def test_the_system_is_left_as_it_was(solve):
    system = duct()
    before = [system.emission.copy(), system.reflectance.copy(), system.matrix.copy()]
    solve(system)
    for array, old in zip((system.emission, system.reflectance, system.matrix), before, strict=True):
        np.testing.assert_array_equal(array, old)
