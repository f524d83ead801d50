"""A concatenation moves (P - 1) N / P words in log2 P set-ups, a reduction of k scalars k words for each."""

import numpy as np
import pytest

from radiosity.machines.common.collectives import concatenation, reduction
from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.common.node_timing import NodeTiming

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming()


def run(program, nodes):
    cube = hypercube(nodes, TIMING)
    return run_program(program, cube, np.zeros(nodes)), cube.sent[:nodes]


@pytest.mark.parametrize("nodes", [1, 2, 16, 128])
def test_a_concatenation_takes_equation_2_14(nodes):
    ends, sent = run(concatenation(np.full(nodes, 12)), nodes)
    channels = nodes.bit_length() - 1
    assert (sent == (channels, (nodes - 1) * 12)).all()
    assert (ends == channels * TIMING.setup + (nodes - 1) * 12 * TIMING.word).all()


def test_slices_of_any_size_reach_all_nodes():
    sizes = np.array([3, 0, 5, 2, 2, 9, 1, 4])
    program, held = concatenation(sizes), sizes.copy()
    for step in range(3):
        partner = np.arange(8) ^ 1 << step
        assert np.array_equal(program.target[step], partner)
        assert np.array_equal(program.words[step], held)
        held = held + held[partner]
    assert (held == sizes.sum()).all()


@pytest.mark.parametrize("scalars", [1, 2, 3])
def test_scalars_of_a_reduction_share_their_messages(scalars):
    ends, sent = run(reduction(16, scalars), 16)
    assert (sent[:, MESSAGES] == 4).all()
    assert (sent[:, WORDS] == 4 * scalars).all()
    assert (ends == 4 * (TIMING.setup + scalars * TIMING.word)).all()
