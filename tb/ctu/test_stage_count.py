"""Stages are over in their order, and none too early."""

from collections import deque

import numpy as np

from hw.ctu.ctu_formats import GRID_GROUP
from hw.ctu.stage_count import NEAR_STAGE, StageCount, stage_index_bits
from tb.lib.bench import Bench

# More stages cannot be closed and not over, so that their numbers are different.
MOST_CLOSED = 16


class TestStageCount(Bench):
    component, arguments = StageCount, {"exits": 3}
    variants = tuple({"ctu.run_ahead": stages} for stages in (0, 1, 2, 5))

    def model(self, config):
        """The oldest stage is over if it is closed and settled, and all that has entered left three cycles ago."""
        stages = 1 << stage_index_bits(config)
        entered, left = (np.zeros(stages, dtype=int) for _ in range(2))
        self.flying, self.closed, self.oldest, near_over = np.zeros(stages, dtype=int), 0, NEAR_STAGE, 0
        # Of the present cycle and of those before it: what had entered and left before it.
        self.ages = deque([(entered, left)] * 4, maxlen=4)
        given = yield
        while True:
            index = self.oldest % stages
            over = int(self.closed > 0 and given.settled and entered[index] == self.ages[2][1][index])
            outputs = {
                "over": over, "near_over": near_over, "done": int(given.closed_all and not self.closed),
                "rays": sum(1 << int(stage) for stage in np.flatnonzero(np.subtract(*self.ages[3])))}
            self.oldest, self.closed, near_over = (NEAR_STAGE, 0, 0) if given.begins else (
                self.oldest + over, self.closed + given.closes - over, near_over | over)
            entered, left = entered.copy(), left.copy()
            for total, name in (entered, "enters"), *((left, f"left__{k}") for k in range(self.arguments["exits"])):
                if item := getattr(given, name):
                    total[item["stage"] % stages] += item["count"]
            self.flying = entered - left
            self.ages.appendleft((entered, left))
            given = yield outputs

    def items(self, name, shape, random):
        """Rays of the oldest stage and those behind it enter; those that end have entered before."""
        for item in super().items(name, shape, random):
            stage, count = (self.oldest + random.choice((0, 0, 1, item["stage"]))) % 16, random.randint(1, GRID_GROUP)
            index = stage % len(self.flying)
            if name != "enters":
                count = min(count, int(self.flying[index]))
                self.flying[index] -= count
            comes = count and random.random() < (0.2 if name == "enters" else 1)
            yield {"stage": stage, "count": count} if comes else None

    def drive(self, given, random):
        """A frustum begins when nothing is in flight."""
        is_idle = given.enters is None and all((one == other).all() for one, other in self.ages)
        given.begins = int(is_idle and random.random() < 0.2)
        given.closes = int(self.closed < MOST_CLOSED and random.random() < 0.4)
        given.settled = int(random.random() < 0.8)
