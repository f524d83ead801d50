import numpy as np
import pytest

from golden.light.solvers import RadiositySystem
from golden.light.solvers.conjugate_gradient import conjugate_gradient
from golden.light.solvers.gathering import gauss_jacobi, gauss_seidel
from tb.golden.light.solvers.systems import duct, exact, furnace, lit_cube


def test_conjugate_gradients_walk_the_published_duct_history():
    np.testing.assert_allclose(conjugate_gradient(duct(), max_steps=1).radiosity[:, 0], (1, 0, 0), rtol=0, atol=1e-14)
    after_two = conjugate_gradient(duct(), max_steps=2).radiosity[:, 0]
    np.testing.assert_allclose(after_two, (1.08910891, 0.29702970, 0.11881188), rtol=0, atol=6e-9)
    solution = conjugate_gradient(duct())
    assert solution.steps == 3
    np.testing.assert_allclose(solution.errors[:2, 0], (0.28, 0.0109091), rtol=0, atol=5e-8)
    assert solution.errors[2, 0] < 1e-15


def test_fewer_steps_than_gauss_jacobi_on_cast_form_factors():
    system = lit_cube("cast")
    assert conjugate_gradient(system).steps < 0.7 * gauss_jacobi(system).steps


def test_reported_residual_is_that_of_the_system_itself():
    for system in (lit_cube("cast"), furnace(0.8)):
        solution = conjugate_gradient(system)
        residual = np.abs(system.residual(solution.radiosity)).sum(axis=0)
        assert (residual < 5e-6 * solution.radiosity.max(axis=0)).all()


def test_gauss_seidel_takes_over_where_reciprocity_fails():
    generator = np.random.default_rng(8)
    factors = np.triu(generator.random((40, 40)), 1)
    factors /= np.maximum(factors.sum(axis=1, keepdims=True), 1)
    system = RadiositySystem(form_factors=factors, reflectance=np.full((40, 3), 0.95), emission=np.ones((40, 3)),
                             area=np.exp(3 * generator.normal(size=40)))
    solution = conjugate_gradient(system)
    assert solution.converged
    assert solution.steps == len(solution.errors)
    np.testing.assert_allclose(solution.radiosity, exact(system), rtol=1e-5)


@pytest.mark.parametrize("share", [1e-3, 1.0])
def test_black_surfaces_do_not_upset_the_scaling(share):
    system = lit_cube("analytic")
    dark = np.random.default_rng(9).random((len(system), 1)) < share
    system = RadiositySystem(form_factors=system.matrix, reflectance=system.reflectance * ~dark,
                             emission=system.emission, area=system.area)
    np.testing.assert_allclose(conjugate_gradient(system).radiosity, gauss_seidel(system, tolerance=1e-12).radiosity,
                               rtol=0, atol=5e-6)


def test_a_solution_is_converged_only_if_the_recomputed_residual_is_small():
    """Black patches count as nearly black: the residual that the steps carry along is that of another system."""
    system, tolerance = lit_cube("analytic"), 1e-9
    system = RadiositySystem(form_factors=system.matrix, reflectance=system.reflectance * (np.arange(len(system)) > 9)[
        :, None], emission=system.emission, area=system.area)
    whole = conjugate_gradient(system, tolerance=tolerance)
    assert whole.converged
    for steps in range(1, whole.steps):
        found = conjugate_gradient(system, tolerance=tolerance, max_steps=steps)
        error = np.abs(system.residual(found.radiosity)).sum(axis=0) / found.radiosity.max(axis=0)
        assert found.converged == (error < tolerance).all()
