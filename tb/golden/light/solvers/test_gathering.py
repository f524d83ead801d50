import numpy as np
import pytest

from golden.light.solvers.gathering import gauss_jacobi, gauss_seidel, over_relaxation
from tb.golden.light.solvers.systems import duct, furnace, lit_cube


def test_gauss_jacobi_walks_the_published_duct_history():
    published = [(1, 0.2, 0.08), (1.06, 0.248, 0.104), (1.076, 0.2744, 0.11456), (1.08392, 0.283936, 0.119008)]
    for steps, radiosity in enumerate(published, start=2):
        # A run of k steps looks at k states, the first being the emission.
        np.testing.assert_allclose(gauss_jacobi(duct(), max_steps=steps).radiosity[:, 0], radiosity, rtol=0, atol=1e-12)
    solution = gauss_jacobi(duct())
    np.testing.assert_allclose(solution.errors[:4, 0], (0.28, 0.132, 0.0499623, 0.0203569), rtol=0, atol=5e-8)
    assert solution.steps == 14


def sweep_patch_by_patch(system, omega, radiosity):
    for i in range(len(system)):
        gathered = system.emission[i] + system.reflectance[i] * (system.matrix[i] @ radiosity)
        radiosity[i] = (1 - omega) * radiosity[i] + omega * gathered


@pytest.mark.parametrize("omega", [1.0, 1.3])
def test_blocks_of_patches_give_what_single_patches_give(omega):
    system = lit_cube("analytic")
    radiosity = system.emission.copy()
    for steps in range(1, 4):
        found = over_relaxation(system, omega=omega, max_steps=steps).radiosity
        np.testing.assert_allclose(found, radiosity, rtol=0, atol=1e-14)
        sweep_patch_by_patch(system, omega, radiosity)


def test_gauss_seidel_is_over_relaxation_that_goes_all_the_way_and_no_further():
    np.testing.assert_array_equal(gauss_seidel(duct()).radiosity, over_relaxation(duct(), omega=1.0).radiosity)


def test_each_method_takes_fewer_sweeps_than_the_one_before():
    system = furnace(0.8)
    jacobi, seidel, relaxed = (solve(system).steps for solve in (gauss_jacobi, gauss_seidel, over_relaxation))
    assert relaxed < seidel < jacobi
