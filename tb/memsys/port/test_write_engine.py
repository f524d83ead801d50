"""The write engine's time-out; its bursts are tested at the port, `tb/memsys/port/test_main_memory_port.py`."""


from hw.memsys.port.fault import Fault
from hw.memsys.port.write_engine import WriteEngine
from tb.lib.configurations import config_of
from tb.lib.simulator import simulator_of

TIMEOUT_BITS = 4
CONFIG = config_of({"memory.timeout_bits": TIMEOUT_BITS})
# Cycles of answers, all of them later than those of addresses and data; each in time after the one before.
ANSWERS = 12, 24, 36


def test_each_answer_of_several_bursts_is_progress():
    """A slow memory that answers one after the other is in time; the burst that it does not answer is an error."""
    dut, written, faults = WriteEngine(config=CONFIG, tag=2), [], []

    async def bench(ctx):
        for ready in dut.o_address.ready, dut.o_data.ready, dut.o.ready, dut.i_data.valid:
            ctx.set(ready, 1)
        ctx.set(dut.i_data.payload.strobe, 1)
        sent = addresses = 0
        for cycle in range(100):
            ctx.set(dut.i.valid, sent <= len(ANSWERS))
            ctx.set(dut.i.payload, {"tag": sent, "first": 3 + sent, "length": 0, "ends": 1, "bad": 0})
            ctx.set(dut.i_response.valid, cycle in ANSWERS)
            sent += ctx.get(dut.i.valid & dut.i.ready)
            if ctx.get(dut.o_address.valid):
                addresses += 1
                assert cycle < ANSWERS[0]
            if ctx.get(dut.o.valid):
                written.append((ctx.get(dut.o.payload.tag), ctx.get(dut.o.payload.error)))
            if ctx.get(dut.o_fault.valid):
                faults.append((Fault(ctx.get(dut.o_fault.payload.code)), cycle))
            await ctx.tick()
        assert addresses == sent == len(ANSWERS) + 1

    simulator_of(dut, bench).run()
    assert written == [(0, 0), (1, 0), (2, 0), (3, 1)]
    ((code, cycle),) = faults
    assert code is Fault.WRITE_TIMEOUT
    assert 0 <= cycle - (ANSWERS[-1] + (1 << TIMEOUT_BITS)) <= 3


def test_answers_that_come_too_late_while_the_client_stalls_end_no_burst_twice():
    """After the time-out all bursts are errors, also those that stand behind a stalled answer when memory's have come;
    the next one is not.
    """
    dut, written, count, end = WriteEngine(config=CONFIG, tag=2), [], 3, 60

    async def bench(ctx):
        for ready in dut.o_address.ready, dut.o_data.ready, dut.i_data.valid:
            ctx.set(ready, 1)
        ctx.set(dut.i_data.payload.strobe, 1)
        sent = 0
        for cycle in range(100):
            ctx.set(dut.i.valid, sent < count or (sent == count and cycle >= end + 10))
            ctx.set(dut.i.payload, {"tag": sent, "first": 3 + sent, "length": 0, "ends": 1, "bad": 0})
            ctx.set(dut.o.ready, cycle >= end)
            ctx.set(dut.i_response.valid, end - 10 <= cycle < end - 10 + count or cycle == end + 20)
            sent += ctx.get(dut.i.valid & dut.i.ready)
            if ctx.get(dut.o.valid & dut.o.ready):
                written.append((ctx.get(dut.o.payload.tag), ctx.get(dut.o.payload.error)))
            await ctx.tick()

    simulator_of(dut, bench).run()
    assert written == [(0, 1), (1, 1), (2, 1), (3, 0)]
