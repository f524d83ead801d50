from golden.engine.config import PRESETS
from hw.icu.ray_memory import RayMemory
from hw.icu.read_out import ReadOut
from hw.icu.settle_map import SettleMap
from hw.icu.window_walk import WindowWalk
from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.credit_gate import CreditGate
from hw.lib.fork import Fork
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.port.fault import Fault
from hw.memsys.port.read_engine import ReadEngine
from hw.memsys.port.window_check import WindowCheck
from hw.memsys.port.write_engine import WriteEngine
from tb.formal.bench import Bench
from tb.formal.declare import Claim, Control, declare
from tb.formal.negative_control import NegativeControl
from tb.formal.stream_rules import ready_blind, stream_rules

SMALL = {
    "queue": lambda: Queue(2, depth=3),
    "skid_buffer": lambda: SkidBuffer(2),
    "bypass": lambda: SkidBuffer(2, bypass=True),
    "fork": lambda: Fork(2, count=3),
    "round_robin": lambda: Arbiter(2, count=3),
    "longest_waiting": lambda: Arbiter(2, count=3, policy=ArbiterPolicy.LONGEST_WAITING),
}
ICU = PRESETS["tiny"].replace({"icu.rays": 64, "icu.side_bits": 6, "icu.slots": 16, "icu.settle_bits": 4,
                               "icu.settle_fraction": 2, "icu.patch_bits": 8, "icu.generation_bits": 1})
# Blocks of the intersection unit with a stream that can wait.
BLOCKS = {
    "window_walk": lambda: WindowWalk(config=ICU),
    "settle_map": lambda: SettleMap(config=ICU, tag=1),
    "ray_memory": lambda: RayMemory(config=ICU, tag=1),
    "read_out": lambda: ReadOut(config=ICU),
}
MEMORY = PRESETS["tiny"].replace({"memory.address_bits": 16, "memory.outstanding": 2, "memory.burst_beats": 2,
                                  "memory.length_bits": 2, "memory.timeout_bits": 2})
ENGINES = {
    "read_engine": lambda: ReadEngine(config=MEMORY, tag=2), "write_engine": lambda: WriteEngine(config=MEMORY, tag=2)}
CHECK = {"window_check": lambda: WindowCheck(config=MEMORY, tag=2, fault=Fault.READ_OUTSIDE)}
# It keeps the rules where as many credits come back as were taken: see test_credit_gate.py.
GATE = {"credit_gate": lambda: CreditGate(2, credits=3)}
ALL = SMALL | BLOCKS | ENGINES | CHECK | GATE


def make(name="queue"):
    # Of its neighbours it assumes the rules of streams alone.
    return Bench(stream_rules, ALL[name](), is_checked=False)


test_rules = declare(
    make, cycles=10, claims=[*(Claim(name=name, unbounded=True) for name in (*SMALL, *CHECK)),
                             *(Claim(name=name) for name in BLOCKS)],
    controls={
        "takes an offer back": Control("withdrawn", {"o__valid": lambda dut: dut.o.valid & ~dut.i.valid}),
        "changes an offer": Control("changed", {"o__payload": lambda dut: dut.o.payload ^ dut.i.payload}),
        "offers right after reset": Control("after reset", {"o__valid": lambda dut: dut.level != 1}),
    })

test_rules_of_the_memory_engines = declare(
    make, cycles=14, engine="abc bmc3", covers_nightly=True, claims=[Claim(name=name) for name in ENGINES],
    controls={f"the {name} withdraws an answer": Control(
        "withdrawn", {"o__valid": lambda dut: dut.o.valid & ~dut.i.valid}, name=name, nightly=name == "write_engine")
        for name in ENGINES})


def make_blind(name="queue", wrong=None):
    dut, copy = (NegativeControl(ALL[name](), wrong) if wrong else ALL[name]() for _ in range(2))
    return Bench(ready_blind, dut, copy=copy, is_checked=False)


test_offers_do_not_depend_on_ready = declare(
    make_blind, cycles=6, claims=[Claim(name=name) for name in (*SMALL, *GATE)],
    controls={"offers when it is taken": Control(
        "blind", wrong={"o__valid": lambda dut: dut.o.valid & dut.o.ready})})
