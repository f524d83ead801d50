"""Gathering on a hypercube is simulated by commands, and its benchmark grades the source's tables."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import radiosity.cli.main
from benchmarks.furnished_room import furnished_room
from benchmarks.gathering import BAND, ENTRIES, FORM_FACTORS, balanced_errors, iteration_seconds, orders_of, sized_rows
from radiosity.cli.golden import choices
from radiosity.machines.common.assignment import ASSIGNMENTS, shares
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.node_matrix import NodeMatrix
from radiosity.machines.gather.parallel_solvers import COMPLETIONS, PARALLEL_SOLVERS
from radiosity.machines.gather.row_phase import SCHEMES

pytestmark = [pytest.mark.xdist_group("machines"), pytest.mark.usefixtures("interpreted")]

SMALL = ("cornell", "--patches", "48", "--rays", "16x8")


def run(*words):
    return CliRunner().invoke(radiosity.cli.main.main, ["machine", "gather", *words])


def test_the_command_prints_one_object():
    words = (*SMALL, "--nodes", "8", "--json")
    reports = [json.loads(run(*words, *more).output) for more in (
        (), ("--scheme", "sharing", "--assignment", "tiled"),
        ("--scheme", "circulation", "--solver", "conjugate-gradient", "--completion", "merge"))]
    assert {"scene", "seconds", "efficiency", "traffic", "memory", "of_a_node", "F"} <= reports[0].keys()
    assert len({one["F"] for one in reports}) == 1
    assert reports[0]["radiosity"] == reports[1]["radiosity"]
    assert (reports[0]["nodes"], reports[0]["patches"], reports[0]["assignment"]) == (8, 48, None)
    assert (reports[1]["assignment"], reports[2]["assignment"]) == ("tiled", "random")
    assert reports[2]["traffic"]["circulated_words"] > 0


def test_text_has_both_phases():
    output = run(*SMALL, "--nodes", "4", "--granularity", "3").output
    assert "48 patches" in output
    assert "4 nodes, scheme demand-driven" in output
    assert "48 rows before a memory was full" in output
    assert "rows of a node: " in output


def test_steps_end_with_all_rows_in_the_nodes_that_solve(tmp_path):
    """49 squares of 8 x 8 pixels, the last of which is none of the 48 rows; in the first frame rows are still made."""
    file = tmp_path / "steps.png"
    words = (*SMALL, "--nodes", "4", "--scheme", "sharing", "--completion", "merge")
    assert run(*words, "--steps", str(file)).exit_code == 0
    with Image.open(file) as picture:
        frames = [np.asarray(picture)[:, begin:begin + 56] for begin in range(0, 6 * 60, 60)]
    rows = [frame.reshape(7, 8, 7, 8, 3).swapaxes(1, 2).reshape(49, 8, 8, 3) for frame in frames]
    stored = [int(each.any(axis=(1, 2, 3)).sum()) for each in rows]
    assert stored == sorted(stored)
    assert 0 < stored[0] < stored[3] < stored[4] == stored[5] == 48
    colours = [len(np.unique(each[:48].reshape(-1, 3), axis=0)) for each in rows[4:]]
    assert colours == [4, 4]
    # Equal shares of the entries split rows, at three bounds of four nodes at most.
    is_split = [(each != each[:, :1, :1]).any(axis=(1, 2, 3)).sum() for each in rows]
    assert is_split[:5] == [0] * 5
    assert 1 <= is_split[5] <= 3


@pytest.mark.parametrize(("words", "message"), [
    (("--nodes", "12"), "--nodes: Nodes must be a power of two up to 1024, not 12"),
    (("--nodes", "64"), "--nodes: Nodes must be at most the 48 patches, not 64"),
    (("--assignment", "tiled"), "--assignment needs --scheme circulation or --scheme sharing"),
    (("--scheme", "sharing", "--granularity", "2"), "--granularity needs --scheme demand-driven"),
    (("--memory", "0"), "--memory: Memory must be at least 1, not 0"),
    (("--memory", "1000000"), "--memory: Memory must be more than 1293184 bytes for a node with 48 patches"),
    (("--steps", "rows.svg"), "Name must end in .png, not '.svg'"),
    (("--scheme", "sharing", "--seed", "-1"), "--seed: Seed must be at least 0, not -1"),
    (("--seed", "1"), "--seed needs --assignment random and --scheme circulation or --scheme sharing"),
    (("--scheme", "sharing", "--assignment", "tiled", "--seed", "1"), "--seed needs --assignment random"),
    (("--rays", "3x3"), "--rays: Azimuths must be a power of two"),
    (("--patches", "19"), "Patches must be 20 to 1048576, not 19")])
def test_wrong_machines_are_refused(words, message):
    done = run(*SMALL, *words)
    assert done.exit_code == 2
    assert done.stderr.count("\n") == 1
    assert message in done.stderr


def test_options_have_the_names_of_their_registries():
    assert choices.GATHER_SCHEMES == SCHEMES
    assert choices.GATHER_ASSIGNMENTS == ASSIGNMENTS
    assert tuple(PARALLEL_SOLVERS) == choices.GATHER_SOLVERS
    assert choices.GATHER_COMPLETIONS == COMPLETIONS


def drawn_rows(patches, nodes):
    """Rows of drawn lengths, with the source's numbers of rows and entries."""
    matrix = sized_rows(np.random.default_rng(patches).integers(1, 9, patches), ENTRIES[patches])
    return NodeMatrix.of_rows(matrix, np.append(0, np.cumsum(shares(patches, nodes))))


def test_all_balanced_iterations_of_table_2_2_are_reproduced_by_the_cost_model_alone():
    errors = balanced_errors(NodeTiming(), drawn_rows)
    assert len(errors) == 12
    assert max(map(abs, errors.values())) <= BAND


@pytest.mark.parametrize("without", [{"setup": 0, "word": 0}, {"setup": 0}, {"operation": 5700}])
def test_they_are_not_without_a_part_of_it(without):
    assert max(map(abs, balanced_errors(NodeTiming(**without), drawn_rows).values())) > BAND


def test_balanced_iterations_are_faster():
    even, uneven = sized_rows(np.ones(64), 2000), sized_rows(np.arange(1, 65), 2000)
    bounds = np.arange(0, 65, 8)
    seconds = [iteration_seconds(NodeMatrix.of_rows(one, bounds), NodeTiming()) for one in (even, uneven)]
    assert seconds[0] < seconds[1]


@pytest.mark.parametrize("entries", [100, 101, 1003])
def test_rows_are_scaled_to_a_number_of_entries(entries):
    matrix = sized_rows(np.arange(1, 41), entries)
    assert matrix.nnz == entries
    sizes = np.diff(matrix.indptr)
    assert np.abs(sizes - np.arange(1, 41) * entries / 820).max() <= 1
    assert all(len(set(matrix[[row]].indices)) == size for row, size in enumerate(sizes) if size <= 40)


def test_the_source_s_orders_are_those_of_its_text():
    """Demand-driven and random sharing are always before the others; circulation is behind tiles in 15 of 19."""
    cases = {case: dict(zip(("circulation", "sharing", "sharing, tiled", "demand-driven"), seconds, strict=True))
             for case, seconds in FORM_FACTORS.items()}
    assert list(orders_of(cases).values()) == [19, 19, 15]


def test_rooms_have_any_number_of_patches():
    assert [len(furnished_room(patches)) for patches in (248, 300, 886)] == [248, 300, 886]


@pytest.mark.nightly
def test_1024_nodes_gather_16384_rows():
    report = json.loads(run("lobby", "--patches", "16384", "--nodes", "1024", "--rays", "16x8", "--scheme",
                            "circulation", "--completion", "merge", "--json").output)
    assert (report["nodes"], report["patches"]) == (1024, 16384)
    assert report["of_a_node"]["rows"] == {"least": 16, "mean": 16.0, "most": 16}
    assert report["of_a_node"]["entries"]["most"] - report["of_a_node"]["entries"]["least"] <= 1
