"""Form factors are golden's, byte for byte, under all schemes; so are solutions, as long as rows are whole."""

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse

from golden.cast.frame import frame
from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Rays
from golden.light.form_factors import gauss_points, patch_columns
from radiosity.machines.common.assignment import ASSIGNMENTS, assign
from radiosity.machines.common.hypercube import hypercube
from radiosity.machines.gather.gather_run import simulate_gather, solution_times
from radiosity.machines.gather.node_matrix import NodeMatrix
from radiosity.machines.gather.node_memory import NodeMemory
from radiosity.machines.gather.parallel_solvers import COMPLETIONS, PARALLEL_SOLVERS
from radiosity.machines.gather.redistribution import redistributed
from radiosity.machines.gather.row_phase import SCHEMES, GatherScheme
from tb.radiosity.machines.gather.nodes import room

pytestmark = pytest.mark.usefixtures("interpreted")

PATCHES = 40


def run(*, solver="gauss-jacobi", nodes=4, completion=None, memory=None, **scheme):
    _, system, work = room(PATCHES)
    return simulate_gather(system, work, GatherScheme(**scheme), nodes=nodes, solver=solver, completion=completion,
                           memory=memory)


def small(nodes):
    """A memory for half of a node's rows beside all patches."""
    _, system, _ = room(PATCHES)
    rows = 8 * (system.matrix.nnz + PATCHES) // nodes
    return NodeMemory(size=(1 << 20) + 240_000 + PATCHES * 96 + rows // 2)


RUNS = [pytest.param(scheme, kind, nodes, is_small, marks=pytest.mark.nightly if kind == "scattered" else [])
        for scheme, kind, nodes, is_small in product(SCHEMES, ASSIGNMENTS, (2, 8), (False, True))
        if (scheme != "demand-driven" or kind == "random") and nodes == (8 if is_small else 2)]


@pytest.fixture(scope="module")
def one():
    return {solver: run(solver=solver, nodes=1).report() for solver in PARALLEL_SOLVERS}


@pytest.mark.parametrize(("scheme", "kind", "nodes", "is_small"), RUNS)
def test_rows_and_solutions_have_the_same_bytes(one, scheme, kind, nodes, is_small):
    _, system, _ = room(PATCHES)
    found = run(name=scheme, assignment=kind, nodes=nodes, memory=small(nodes) if is_small else None)
    assert [getattr(found.factors, name).tobytes() for name in ("data", "indices", "indptr")] == [
        getattr(system.matrix, name).tobytes() for name in ("data", "indices", "indptr")]
    assert (found.rows.before_full == PATCHES) == (not is_small and scheme != "circulation")
    report = found.report()
    assert (report["F"], report["radiosity"]) == (one["gauss-jacobi"]["F"], one["gauss-jacobi"]["radiosity"])
    assert report["solution"]["iterations"] == one["gauss-jacobi"]["solution"]["iterations"]


@pytest.mark.parametrize("solver", PARALLEL_SOLVERS)
@pytest.mark.parametrize("completion", COMPLETIONS)
def test_redistributed_rows_keep_their_bytes_and_the_solution_to_rounding(one, solver, completion):
    found, whole = (run(solver=solver, name="sharing", nodes=8, completion=each) for each in (completion, None))
    assert found.report()["F"] == one[solver]["F"]
    assert whole.report()["radiosity"] == one[solver]["radiosity"]
    assert found.matrix.is_split.any()
    assert np.allclose(found.radiosity, whole.radiosity, rtol=1e-12, atol=0)
    assert [each.iterations for each in found.channels] == one[solver]["solution"]["iterations"]


def test_a_row_that_is_projected_block_by_block_is_golden_s():
    """Nearest hits of the blocks of patches, merged in any order, are those of all patches at once."""
    scene, system, _ = room(PATCHES)
    hemisphere, (points, _) = Hemisphere(16, 8), gauss_points(scene, 1)
    held, columns = assign("random", PATCHES, 4, seed=2), patch_columns(scene)
    for patch, first in ((3, 0), (20, 1), (31, 3)):
        rays = Rays(np.repeat(points[patch], len(hemisphere), axis=0),
                    hemisphere.directions @ frame(scene.normals[patch]), source=np.full(len(hemisphere),
                                                                                      scene.surface[patch]))
        nearest, depth = np.full(len(hemisphere), -1), np.full(len(hemisphere), np.inf)
        for step in range(4):
            block = np.sort(held.patches((first + step) % 4))
            hits = Grid(_part(scene, block)).nearest(rays)
            is_nearer = (hits.patch >= 0) & (hits.t < depth)
            nearest[is_nearer], depth[is_nearer] = block[hits.patch[is_nearer]], hits.t[is_nearer]
        met = np.flatnonzero(nearest >= 0)
        column = columns(rays.direction[met], SimpleNamespace(patch=nearest[met]))
        row = np.bincount(column[column >= 0], hemisphere.weights[met][column >= 0], PATCHES)
        assert np.array_equal(row / 2**hemisphere.weight_bits, system.matrix[[patch]].toarray()[0])


def _part(scene, patches):
    return replace(scene, **{name: getattr(scene, name)[patches] for name in (
        "vertices", "material", "surface", "smooth", "two_sided")})


def test_a_report_has_times_traffic_memory_and_the_extremes_of_the_nodes():
    report = run(name="sharing", nodes=4, completion="merge").report()
    assert report["seconds"] == report["form_factors"]["seconds"] + report["solution"]["seconds"]
    assert report["of_a_node"]["rows"] == {"least": 10, "mean": 10.0, "most": 10}
    assert report["of_a_node"]["entries"]["most"] - report["of_a_node"]["entries"]["least"] <= 1
    assert report["traffic"]["words"] == 4 * report["of_a_node"]["words_sent"]["mean"]
    assert report["memory"]["most_bytes"] <= report["memory"]["bytes"] == 4 << 20
    assert report["solution"]["renumbering_seconds"] == 0 < report["solution"]["redistribution_seconds"]
    assert 0 < report["efficiency"] < 1


def test_one_node_is_alone():
    found = run(name="sharing", nodes=1)
    assert found.rows.efficiency == 1
    assert found.solution.alone == found.solution.time
    assert found.sent.sum() == 0


@pytest.mark.parametrize("nodes", [1, 4, 16])
@pytest.mark.parametrize("solver", PARALLEL_SOLVERS)
def test_each_part_of_a_solution_begins_on_idle_links(solver, nodes):
    """Channels take the sum of their times alone, and renumbering as long behind a redistribution as without."""
    _, system, work = room(PATCHES)
    bounds = np.linspace(0, PATCHES, nodes + 1).astype(np.int64)
    whole = NodeMatrix.of_rows(sparse.csr_array(system.matrix), bounds)
    matrix = redistributed(whole)

    def times(iterations, completion="merge"):
        return solution_times(whole, matrix, solver, hypercube(nodes, work.timing), work.timing, iterations=iterations,
                              completion=completion)

    each = [times([count]).solving for count in (5, 2, 7)]
    assert times([5, 2, 7]).solving == sum(each)
    moved = times([5])
    assert moved.renumbering == times([5], None).renumbering
    assert moved.redistribution > 0


def test_a_new_light_takes_the_solution_alone():
    """Rows, their order and their bounds do not depend on emissions and reflectances."""
    found = run(nodes=8, completion="merge")
    _, system, work = room(PATCHES)
    relit = type(system)(form_factors=system.matrix, area=system.area, reflectance=0.5 * system.reflectance,
                         emission=np.roll(system.emission, 7, axis=0))
    again = simulate_gather(relit, work, GatherScheme(), nodes=8, completion="merge")
    assert np.array_equal(again.rows.assignment.order, found.rows.assignment.order)
    assert np.array_equal(again.matrix.entries, found.matrix.entries)
    assert again.solution.iterations < found.solution.iterations
