from amaranth.sim import Simulator
from hypothesis import example, given
from hypothesis import strategies as st

from golden.config import PRESETS
from hw.control.cluster_faults import ClusterFaults
from hw.ctu.subshell_generator import ListError
from hw.memsys.path_fault import PathFault
from hw.registers.error_code import ErrorCode
from tb.lib.schedules import SETTINGS

CONFIG = PRESETS["tiny"]
NOTHING, QUIET = (ErrorCode.NONE, 0), {"memory": None, "final": 0, "error": ListError.NONE, "clear": 0}
LISTED = QUIET | {"final": 1, "error": ListError.PATCH}
LOST = QUIET | {"memory": (PathFault.BUS, 5)}
LATE = QUIET | {"memory": (PathFault.TIMEOUT, 0)}
CLEAR = {"clear": 1}
# In ``memory``: the memory system finds a fault.
CYCLES = st.fixed_dictionaries({
    "final": st.booleans(), "error": st.sampled_from(list(ListError)),
    "memory": st.one_of(st.none(), st.none(), st.tuples(
        st.sampled_from([code for code in PathFault if code is not PathFault.NONE]), st.integers(0, 1000))),
    "clear": st.sampled_from([0, 0, 1])})


def expected_of(cycles):
    """The faults before each cycle: of the memory system, which latches its own, and of the cluster."""
    memory, fault = (PathFault.NONE, 0), NOTHING
    for one in cycles:
        yield memory, fault
        held = memory
        if one["clear"]:
            fault, memory, held = NOTHING, (PathFault.NONE, 0), (PathFault.NONE, 0)
        if held[0] is PathFault.TIMEOUT:
            fault = ErrorCode.PATH_TIMEOUT, held[1]
        elif fault == NOTHING:
            if held[0] is not PathFault.NONE:
                fault = (ErrorCode[f"PATH_{held[0].name}"], held[1])
            elif one["final"] and one["error"] is not ListError.NONE:
                fault = (ErrorCode[f"LIST_{one['error'].name}"], 0)
        if one["memory"] and (memory[0] is PathFault.NONE or one["memory"][0] is PathFault.TIMEOUT):
            memory = one["memory"]


@SETTINGS
@given(st.lists(CYCLES, max_size=16))
@example([LISTED | CLEAR, QUIET])
@example([LOST, QUIET, LISTED | CLEAR, QUIET])
@example([LOST, QUIET, QUIET | CLEAR, QUIET])
@example([LOST | CLEAR, QUIET, QUIET])
@example([LISTED, LOST, LATE, QUIET, QUIET])
def test_the_first_fault_stays_until_it_is_cleared(cycles):
    """But for a time-out, which ends in a reset; and none is lost that comes in the cycle of a clear."""
    dut, found, expected = ClusterFaults(config=CONFIG), [], list(expected_of(cycles))

    async def bench(ctx):
        for one, ((code, number), _) in zip(cycles, expected, strict=True):
            for name in ("final", "error", "clear"):
                ctx.set(getattr(dut, name), one[name])
            ctx.set(dut.memory, {"code": code, "number": number})
            found.append((ErrorCode(ctx.get(dut.fault.code)), ctx.get(dut.fault.number)))
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == [fault for _, fault in expected]
