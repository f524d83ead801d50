"""Nodes work, send and wait step by step, each at its own pace."""

import numpy as np
import pytest

from radiosity.machines.common.hypercube import hypercube
from radiosity.machines.common.node_programs import joined, run_program, work_step
from radiosity.machines.common.node_timing import NodeTiming

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming(setup=100, word=10)


def around(nodes, words):
    """A step in which each node sends to the one before it."""
    step = work_step(np.zeros(nodes, dtype=np.int64))
    step.target[0], step.source[0] = np.roll(np.arange(nodes), 1), np.roll(np.arange(nodes), -1)
    step.words[0] = words
    return step


def test_a_node_without_messages_only_works():
    program = joined(work_step([5, 7]), work_step([1, 2]))
    assert run_program(program, hypercube(2, TIMING), np.array([0, 3]), rounds=4).tolist() == [24, 39]


def test_the_sender_goes_on_after_its_set_up_and_the_target_waits_for_the_last_word():
    program = work_step([0, 50])
    program.target[0, 0], program.source[0, 1], program.words[0, 0] = 1, 0, 6
    assert run_program(program, hypercube(2, TIMING), np.zeros(2)).tolist() == [100, 100 + 60]


def test_an_early_message_waits():
    program = work_step([0, 5000])
    program.target[0, 0], program.source[0, 1], program.words[0, 0] = 1, 0, 6
    assert run_program(program, hypercube(2, TIMING), np.zeros(2)).tolist() == [100, 5000]


def test_messages_for_nodes_that_do_not_wait_are_refused():
    step = around(4, 1)
    step.source[0, 2] = -1
    with pytest.raises(ValueError, match="expect a message from the sender"):
        run_program(step, hypercube(4, TIMING), np.zeros(4))
    step = around(4, 1)
    step.target[0, 2] = -1
    with pytest.raises(ValueError, match="expect a message from the sender"):
        run_program(step, hypercube(4, TIMING), np.zeros(4))


def test_no_rounds_take_no_time():
    assert run_program(around(4, 1), hypercube(4, TIMING), np.arange(4), rounds=0).tolist() == [0, 1, 2, 3]
