import pytest

from golden.engine.config import PRESETS
from hw.lib.first_fault import FirstFault
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from tb.lib.bench import Bench

LAYOUT, COUNT = MemoryFormats(PRESETS["tiny"]).fault, 3
NONE, URGENT = {"code": Fault.NONE.value, "address": 0}, Fault.READ_TIMEOUT.value


class TestFirstFault(Bench):
    component, variants, span = FirstFault, ({},), 400
    arguments = {"layout": LAYOUT, "count": COUNT, "urgent": URGENT}
    # The last parts have few faults, so that the latch is empty between them.
    chances = (*Bench.chances, (0.1, 1), (0.02, 1))

    def model(self, config):
        """The first one stays until it is cleared, but for an urgent one; of several the lowest input's."""
        kept = NONE
        given = yield
        while True:
            outputs, faults = {"o": kept}, [getattr(given, f"i__{k}") for k in range(COUNT)]
            # One that comes in the cycle of a clear is not an earlier one.
            kept = NONE if given.clear else kept
            if kept == NONE:
                kept = next(filter(None, faults), NONE)
            if faults[0] and faults[0]["code"] == self.arguments["urgent"]:
                kept = faults[0]
            given = yield outputs

    def items(self, name, shape, random):
        """Faults of all kinds; a fault has a code."""
        for item in super().items(name, shape, random):
            yield item | {"code": random.choice([one for one in Fault if one is not Fault.NONE]).value}

    def drive(self, given, random):
        """Now and then a clear."""
        given.clear = random.random() < 0.1


class TestWithoutUrgent(TestFirstFault):
    arguments = {**TestFirstFault.arguments, "urgent": None}
    test_in_the_simulator = None


def test_count_must_be_a_number_of_inputs():
    with pytest.raises(ValueError, match=r"^Count must be at least 1, not 0$"):
        FirstFault(layout=LAYOUT, count=0)
    with pytest.raises(TypeError, match=r"^Count must be"):
        FirstFault(layout=LAYOUT, count=None)
