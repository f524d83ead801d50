import pytest

from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.credit_gate import CreditGate
from hw.lib.fork import Fork
from hw.lib.join import Join
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer
from tb.formal.prove import prove
from tb.formal.stream_rules import ReadyBlind, StreamRules
from tb.formal.twin import Twin

SMALL = {
    "queue": lambda: Queue(2, depth=3),
    "skid_buffer": lambda: SkidBuffer(2),
    "fork": lambda: Fork(2, count=3),
    "join": lambda: Join({"a": 2, "b": 2}),
    "round_robin": lambda: Arbiter(2, count=3),
    "longest_waiting": lambda: Arbiter(2, count=3, policy=ArbiterPolicy.LONGEST_WAITING),
}
FAULTS = {
    "takes an offer back": {"o__valid": lambda dut: dut.o.valid & ~dut.i.valid},
    "changes an offer": {"o__payload": lambda dut: dut.o.payload ^ dut.i.payload},
    "offers right after reset": {"o__valid": lambda dut: dut.level != 1},
}


@pytest.mark.parametrize("name", SMALL)
def test_rules(name):
    assert prove(StreamRules(SMALL[name]()))


@pytest.mark.parametrize("fault", FAULTS)
def test_broken_twin(fault):
    assert not prove(StreamRules(Twin(Queue(2, depth=3), FAULTS[fault])), mode="bmc", depth=6)


# Keeps the rules where as many credits come back as were taken: see test_credit_gate.py.
BLIND = {**SMALL, "credit_gate": lambda: CreditGate(2, credits=3)}


@pytest.mark.parametrize("name", BLIND)
def test_offers_do_not_depend_on_ready(name):
    assert prove(ReadyBlind(BLIND[name](), BLIND[name]()), mode="bmc", depth=6)


def test_one_that_waits_for_ready():
    waits = {"o__valid": lambda dut: dut.o.valid & dut.o.ready}
    assert not prove(ReadyBlind(*(Twin(Queue(2, depth=3), waits) for _ in range(2))), mode="bmc", depth=6)
