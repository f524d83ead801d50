from hw.control.cluster_faults import ClusterFaults
from hw.ctu.subshell_generator import ListError
from hw.memsys.patches.path_fault import PathFault
from hw.registers.error_code import ErrorCode
from tb.lib.bench import Bench

NONE = {"code": 0, "number": 0}


class TestClusterFaults(Bench):
    """The first fault stays until it is cleared, but for a time-out; none is lost in the cycle of a clear."""

    component, variants, span = ClusterFaults, ({},), 250

    def model(self, config):
        """The memory system's fault is an earlier one in the cycle of a clear."""
        self.memory, fault = NONE, NONE
        given = yield
        while True:
            outputs = {"fault": fault}
            held = NONE if given.clear else given.memory
            fault = NONE if given.clear else fault
            if held["code"] == PathFault.TIMEOUT.value:
                fault = {"code": ErrorCode.PATH_TIMEOUT.value, "number": held["number"]}
            elif fault == NONE and held != NONE:
                fault = {"code": ErrorCode[f"PATH_{PathFault(held['code']).name}"].value, "number": held["number"]}
            elif fault == NONE and given.ends and given.error != ListError.NONE.value:
                fault = {"code": ErrorCode[f"LIST_{ListError(given.error).name}"].value, "number": 0}
            given = yield outputs

    def drive(self, given, random):
        """The memory system latches its fault until a clear; a time-out replaces it."""
        given.clear, given.ends = random.random() < 0.15, random.random() < 0.3
        given.error = random.choice([*ListError]).value
        given.memory = self.memory
        found = {"code": random.choice([one for one in PathFault if one is not PathFault.NONE]).value,
                 "number": random.randrange(1000)}
        if given.clear:
            self.memory = NONE
        if random.random() < 0.1 and (self.memory == NONE or found["code"] == PathFault.TIMEOUT.value):
            self.memory = found
