import pytest

from golden.config import PRESETS
from hw.icu.ray_memory import RayMemory
from hw.icu.read_out import ReadOut
from hw.icu.settle_map import SettleMap
from hw.icu.window_walk import WindowWalk
from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.credit_gate import CreditGate
from hw.lib.fork import Fork
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import ReadyBlind, StreamRules

SMALL = {
    "queue": lambda: Queue(2, depth=3),
    "skid_buffer": lambda: SkidBuffer(2),
    "fork": lambda: Fork(2, count=3),
    "round_robin": lambda: Arbiter(2, count=3),
    "longest_waiting": lambda: Arbiter(2, count=3, policy=ArbiterPolicy.LONGEST_WAITING),
}
CONFIG = PRESETS["tiny"].replace({"icu.rays": 64, "icu.side_bits": 6, "icu.slots": 16, "icu.settle_bits": 4,
                                  "icu.settle_fraction": 2, "icu.patch_bits": 8, "icu.generation_bits": 1})
# Blocks of the intersection unit with a stream that can wait.
BLOCKS = {
    "window_walk": lambda: WindowWalk(config=CONFIG),
    "settle_map": lambda: SettleMap(config=CONFIG, tag=1),
    "ray_memory": lambda: RayMemory(config=CONFIG, tag=1),
    "read_out": lambda: ReadOut(config=CONFIG),
}
FAULTS = {
    "takes an offer back": {"o__valid": lambda dut: dut.o.valid & ~dut.i.valid},
    "changes an offer": {"o__payload": lambda dut: dut.o.payload ^ dut.i.payload},
    "offers right after reset": {"o__valid": lambda dut: dut.level != 1},
}


@pytest.mark.parametrize("name", SMALL)
def test_rules(name):
    assert prove(StreamRules(SMALL[name]()))


@pytest.mark.parametrize("name", BLOCKS)
def test_rules_of_the_intersection_unit(name):
    assert prove(StreamRules(BLOCKS[name]()), mode="bmc", depth=10)


@pytest.mark.parametrize("name", [*SMALL, *BLOCKS])
def test_reaches_a_wait(name):
    assert prove(StreamRules((SMALL | BLOCKS)[name]()), mode="cover", depth=10)


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    assert not prove(StreamRules(NegativeControl(Queue(2, depth=3), FAULTS[fault])), mode="bmc", depth=6)


# Keeps the rules where as many credits come back as were taken: see test_credit_gate.py.
BLIND = {**SMALL, "credit_gate": lambda: CreditGate(2, credits=3)}


@pytest.mark.parametrize("name", BLIND)
def test_offers_do_not_depend_on_ready(name):
    assert prove(ReadyBlind(BLIND[name](), BLIND[name]()), mode="bmc", depth=6)


def test_one_that_waits_for_ready():
    waits = {"o__valid": lambda dut: dut.o.valid & dut.o.ready}
    assert not prove(ReadyBlind(*(NegativeControl(Queue(2, depth=3), waits) for _ in range(2))), mode="bmc", depth=6)
