"""Requests of several sources at one port: the data of each follow its request, the answers too, and none waits for
ever.
"""

from amaranth.hdl import Assert, Assume, Cover, Signal
from amaranth.lib.data import StructLayout

from golden.engine.config import PRESETS
from hw.lib.queue import Queue
from hw.memsys.port.write_merge import DEPTH, WriteMerge
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.fifo_order import add_fifo_order
from tb.formal.source_fault import source_fault
from tb.formal.stream_rules import add_rules

COUNT, ENGINE = 3, "abc bmc3"
# Requests of one or two beats.
CONFIG = PRESETS["tiny"].replace({"memory.length_bits": 1, "memory.address_bits": 16})
# Cycles from an offer to the transfer of its request, at a port that accepts everything at once, while all sources
# send their data: two requests of two beats of each other source, those that wait at the port, and its own grant.
BOUND = 16


def add_inputs(m, dut):
    """The rules of streams, and an answer's tag: the component claims it in machines with checks."""
    for one in (*dut.i_request, *dut.i_data, dut.i_written):
        add_rules(m, one, Assume)
    m.d.comb += Assume(dut.i_written.payload.tag < COUNT)


def whose_data(m, bench, dut):
    """Beats are accepted from the source of the oldest request that misses some; all leave in this order."""
    add_inputs(m, dut)
    # Requests that are accepted and not all of whose beats are.
    m.submodules.requested = requested = Queue(StructLayout({"source": range(COUNT), "length": 1}), depth=DEPTH + 2)
    granted, taken = Signal(COUNT), Signal(COUNT)
    request, head, beat = Signal(dut.o_request.payload.shape()), requested.o.payload, Signal()
    # Other bits of the data are treated alike.
    beats = Signal(2)
    for k in range(COUNT):
        m.d.comb += [granted[k].eq(transfers(dut.i_request[k])), taken[k].eq(transfers(dut.i_data[k]))]
        with m.If(granted[k]):
            given = dut.i_request[k].payload
            m.d.comb += [requested.i.payload.source.eq(k), requested.i.payload.length.eq(given.length),
                         request.tag.eq(k), request.address.eq(given.address), request.length.eq(given.length)]
        with m.If(taken[k]):
            m.d.comb += [beats.eq(dut.i_data[k].payload.data), Assert(requested.o.valid, "requested"),
                         Assert(head.source == k, "source")]
    m.d.comb += [
        Assert((granted & (granted - 1)) == 0, "one request"), Assert((taken & (taken - 1)) == 0, "one beat"),
        requested.i.valid.eq(granted.any()), requested.o.ready.eq(taken.any() & (beat == head.length)),
        Cover(requested.o.ready & (head.source == 2) & head.length, "the last source's second beat")]
    with m.If(granted.any()):
        m.d.comb += Assert(requested.i.ready, "capacity")
    with m.If(taken.any()):
        m.d.sync += beat.eq((beat == 0) & head.length)
    mark = bench.free(1, "mark")
    # Entries of the queue; registers of the skid buffer.
    add_fifo_order(m, push=granted.any(), pushed=request, pop=transfers(dut.o_request), popped=dut.o_request.payload,
                   capacity=DEPTH, mark=mark)
    add_fifo_order(m, push=taken.any(), pushed=beats, pop=transfers(dut.o_data), popped=dut.o_data.payload.data[:2],
                   capacity=2, mark=bench.free(1, "mark_of_data"))


def whose_answer(m, bench, dut):
    """Each answer goes to the source that its tag names, in order."""
    add_inputs(m, dut)
    out, item = Signal(COUNT), Signal.like(dut.i_written.payload)
    for k, answer in enumerate(dut.o_written):
        m.d.comb += out[k].eq(transfers(answer))
        with m.If(out[k]):
            m.d.comb += [item.tag.eq(k), item.error.eq(answer.payload.error)]
        add_rules(m, answer, Assert)
    m.d.comb += Assert((out & (out - 1)) == 0, "one")
    add_fifo_order(m, push=transfers(dut.i_written), pushed=dut.i_written.payload, pop=out.any(), popped=item,
                   capacity=2, mark=bench.free(1, "mark"))


def fair(m, bench, dut):
    """A request waits for at most ``COUNT`` - 1 grants of others, and not for ever."""
    add_inputs(m, dut)
    granted, after_reset = Signal(COUNT), Signal(init=1)
    m.d.sync += after_reset.eq(0)
    m.d.comb += [Assume(dut.o_request.ready), Assume(dut.o_data.ready)]
    for k, (request, data) in enumerate(zip(dut.i_request, dut.i_data, strict=True)):
        others, waited = Signal(range(COUNT + 2), name=f"others_{k}"), Signal(range(BOUND + 2), name=f"waited_{k}")
        m.d.comb += [granted[k].eq(transfers(request)), Assume(data.valid | after_reset)]
        with m.If(~request.valid | granted[k]):
            m.d.sync += [others.eq(0), waited.eq(0)]
        with m.Else():
            m.d.sync += [others.eq(others + (granted.any() & (others != COUNT + 1))),
                         waited.eq(waited + (waited != BOUND + 1))]
        m.d.comb += [Assert(others < COUNT, "turn"), Assert(waited <= BOUND, "bound"),
                     Cover((others == COUNT - 1) & granted[k], "the last turn")]


def make(rules, right=None, wrong=None):
    """A bench of the merge, or of one with a fault."""
    dut = source_fault(WriteMerge, right, wrong) if right else WriteMerge
    return Bench(rules, dut(config=CONFIG, count=COUNT))


test_data = declare(
    lambda **fault: make(whose_data, **fault), cycles=10, engine=ENGINE,
    controls={
        "another source": Control("source", right="granted.payload.source == k", wrong="granted.payload.source != k"),
        "a beat too few": Control("requested", right="left.eq(left - 1)", wrong="left.eq(left)"),
        "two grants": Control("one request", right="grant.eq(rule.grant)", wrong="grant.eq(rule.eligible)"),
        "another length": Control("order", {"o_request__payload": lambda dut: dut.o_request.payload.as_value() ^ (
            1 << dut.o_request.payload.shape()["length"].offset)}),
    })
test_answers = declare(
    lambda **fault: make(whose_answer, **fault), cycles=10, claims=[Claim(unbounded=True)],
    controls={
        "another source": Control("order", right="answers.o.payload.tag == number",
                                  wrong="answers.o.payload.tag == (number + 1) % self._count"),
        "all sources": Control("one", right="answers.o.payload.tag == number", wrong="answers.o.valid"),
    })
test_fair = declare(
    lambda **fault: make(fair, **fault), cycles=22, engine=ENGINE,
    controls={
        "the lowest first": Control("turn", right="grant.eq(rule.grant)",
                                    wrong="grant.eq(rule.eligible & (~rule.eligible + 1))"),
    })
