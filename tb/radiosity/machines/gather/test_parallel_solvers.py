"""The solutions are golden's; whole rows give the same bits for any number of nodes, split ones 1e-12."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.light.solvers import SOLVERS, RadiositySystem
from radiosity.machines.common.assignment import assign
from radiosity.machines.gather.node_matrix import NodeMatrix, renumbered
from radiosity.machines.gather.parallel_solvers import COMPLETIONS, PARALLEL_SOLVERS, solve_channel
from radiosity.machines.gather.redistribution import redistributed
from tb.golden.light.solvers.systems import DUCT_RADIOSITY, duct
from tb.radiosity.machines.gather.nodes import drawn_matrix

pytestmark = pytest.mark.usefixtures("interpreted")


def system_of(seed, rows=64):
    rng = np.random.default_rng(seed)
    return RadiositySystem(form_factors=drawn_matrix(seed, rows, most=14), area=rng.random(rows) + 0.1,
                           reflectance=np.outer(rng.random(rows), (1, 1, 1)),
                           emission=np.outer(rng.random(rows) < 0.2, (1, 1, 1)))


def solve(solver, system, *, nodes=1, split=False, completion="merge", seed=0):
    """The solution in the scene's numbers, and its iterations."""
    assignment = assign("random", len(system), nodes, seed=seed)
    matrix = NodeMatrix.of_rows(renumbered(system.matrix, assignment), assignment.bounds)
    found = solve_channel(solver, redistributed(matrix) if split else matrix, completion=completion, **{
        name: getattr(system, name)[assignment.order, 0] for name in ("reflectance", "emission")},
        area=system.area[assignment.order])
    return found.radiosity[assignment.number], found.iterations, found.error


def sparse_duct():
    system = duct()
    return RadiositySystem(form_factors=drawn_matrix(0, 3, most=0).__class__(system.matrix), area=system.area,
                           reflectance=system.reflectance, emission=system.emission)


@pytest.mark.parametrize(("solver", "iterations"), [("gauss-jacobi", 14), ("conjugate-gradient", 3)])
@pytest.mark.parametrize("nodes", [1, 2])
def test_the_duct_is_solved_in_as_many_iterations_as_published(solver, iterations, nodes):
    radiosity, steps, _ = solve(solver, sparse_duct(), nodes=nodes)
    assert steps == iterations
    assert np.allclose(radiosity, DUCT_RADIOSITY, rtol=0, atol=5e-6)


@pytest.mark.parametrize("solver", PARALLEL_SOLVERS)
@pytest.mark.parametrize("seed", range(3))
def test_whole_rows_give_the_same_bits_on_any_number_of_nodes(solver, seed):
    system = system_of(seed)
    one = solve(solver, system)
    for nodes in (2, 8, 32):
        found = solve(solver, system, nodes=nodes, seed=seed)
        assert found[0].tobytes() == one[0].tobytes()
        assert found[1:] == one[1:]


@pytest.mark.parametrize("solver", PARALLEL_SOLVERS)
@pytest.mark.parametrize("completion", COMPLETIONS)
@pytest.mark.parametrize("nodes", [4, 16])
def test_split_rows_differ_by_rounding_alone(solver, completion, nodes):
    system = system_of(5)
    one, other = solve(solver, system), solve(solver, system, nodes=nodes, split=True, completion=completion)
    assert np.allclose(other[0], one[0], rtol=1e-12, atol=0)
    assert other[1] == one[1]


def test_heavy_rows_are_merged_and_not_shifted():
    rng = np.random.default_rng(2)
    factors = np.zeros((40, 40))
    factors[0] = rng.random(40) / 40
    factors[np.arange(1, 40), np.arange(39)] = 0.7
    system = RadiositySystem(form_factors=drawn_matrix(0, 40, most=0).__class__(factors), area=np.ones(40),
                             reflectance=np.full((40, 3), 0.8), emission=np.ones((40, 3)))
    merged = solve("gauss-jacobi", system, nodes=16, split=True)
    assert np.allclose(merged[0], solve("gauss-jacobi", system)[0], rtol=1e-12, atol=0)
    with pytest.raises(InputError, match=r"Completion must be merge for a row that \d+ nodes share, not 'shift'"):
        solve("gauss-jacobi", system, nodes=16, split=True, completion="shift")


@pytest.mark.parametrize("solver", PARALLEL_SOLVERS)
def test_solutions_are_those_of_golden(solver):
    system = sparse_duct()
    found, expected = solve(solver, system), SOLVERS[solver](system)
    assert found[1] == expected.steps
    assert np.allclose(found[0], expected.radiosity[:, 0], rtol=1e-12, atol=0)
    assert np.isclose(found[2], expected.errors[-1, 0], rtol=1e-6, atol=1e-15)


def test_conjugate_gradients_take_fewer_iterations_the_more_light_is_reflected():
    saved = []
    for reflectance in (0.3, 0.6, 0.9):
        rng = np.random.default_rng(1)
        pairs = rng.random((50, 50)) + rng.random((50, 50)).T
        pairs = pairs + pairs.T
        np.fill_diagonal(pairs, 0)
        area = pairs.sum(axis=1)
        system = RadiositySystem(form_factors=drawn_matrix(0, 50, most=0).__class__(pairs / area[:, None]), area=area,
                                 reflectance=np.full((50, 3), reflectance), emission=np.eye(50, 3))
        saved.append(solve("gauss-jacobi", system)[1] - solve("conjugate-gradient", system)[1])
    assert 0 < saved[0] < saved[1] < saved[2]


def test_black_and_dark_patches_are_solved():
    system = system_of(1)
    for reflectance, emission in ((system.reflectance * (np.arange(64) % 2)[:, None], system.emission),
                                  (system.reflectance, 0 * system.emission)):
        changed = RadiositySystem(form_factors=system.matrix, area=system.area, reflectance=reflectance,
                                  emission=emission)
        jacobi, conjugate = (solve(solver, changed, nodes=4)[0] for solver in PARALLEL_SOLVERS)
        assert np.allclose(jacobi, conjugate, rtol=0, atol=1e-5)


@pytest.mark.parametrize(("given", "message"), [
    ({"solver": "shooting"}, "Solver must be one of gauss-jacobi, conjugate-gradient, not 'shooting'"),
    ({"completion": "drop"}, "Completion must be one of shift, merge, not 'drop'"),
    ({"most": 2}, "Iterations must be more than 2 for an error below 5e-06, not 2")])
def test_what_cannot_be_solved_is_refused(given, message):
    system = sparse_duct()
    with pytest.raises(InputError, match=message):
        solve_channel(**{"solver": "gauss-jacobi", "matrix": NodeMatrix.of_rows(system.matrix, np.array([0, 3])),
                         "reflectance": system.reflectance[:, 0], "emission": system.emission[:, 0],
                         "area": system.area} | given)
