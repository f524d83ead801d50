"""Node programs as processes in SimPy, as a reference of `golden.machines.gather.node_programs`.

Links are always free: programs whose messages have links of their own take the same times.
"""

import numpy as np
import simpy

from golden.machines.gather.node_programs import Program
from golden.machines.gather.node_timing import NodeTiming

__all__ = ["simpy_programs"]


def simpy_programs(program: Program, timing: NodeTiming, start, *, rounds: int = 1) -> np.ndarray:
    """The ends of `golden.machines.gather.node_programs.run_program`."""
    env, (steps, nodes) = simpy.Environment(), program.work.shape
    boxes = [[simpy.Store(env) for _ in range(nodes)] for _ in range(steps)]
    ends = np.zeros(nodes, dtype=np.int64)

    def deliver(box, words):
        yield env.timeout(timing.word * words)
        box.put(None)

    def node(number):
        yield env.timeout(int(start[number]))
        for step in (one for _ in range(rounds) for one in range(steps)):
            target = program.target[step, number]
            yield env.timeout(int(program.work[step, number]) + timing.setup * int(target >= 0))
            if target >= 0:
                env.process(deliver(boxes[step][target], int(program.words[step, number])))
            if program.source[step, number] >= 0:
                yield boxes[step][number].get()
        ends[number] = env.now

    for number in range(nodes):
        env.process(node(number))
    env.run()
    return ends
