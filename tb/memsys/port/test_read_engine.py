"""The read engine's time-out, and its faults that come together; its bursts are tested at the port."""

import pytest

from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.read_engine import ReadEngine
from tb.lib.configurations import config_of
from tb.lib.simulator import simulator_of

CONFIG = config_of({"memory.timeout_bits": 4})
FIRST = 5, 9, 77
SLVERR, DECERR = 2, 3


def faults_of(beats, *, length=0, cycles=46):
    """Codes and addresses of the faults, in their order; three bursts are requested in cycles 0 to 2.

    Parameters
    ----------
    beats
        By cycle what memory answers: id, response, last.
    length
        Of all bursts.
    """
    dut, faults = ReadEngine(config=CONFIG, tag=0), []

    async def bench(ctx):
        ctx.set(dut.o_address.ready, 1)
        for cycle in range(cycles):
            ctx.set(dut.i.valid, cycle < len(FIRST))
            if cycle < len(FIRST):
                ctx.set(dut.i.payload, {"first": FIRST[cycle], "length": length, "ends": 1, "bad": 0})
                assert ctx.get(dut.i.ready)
            ctx.set(dut.i_data.valid, cycle in beats)
            if cycle in beats:
                number, response, last = beats[cycle]
                ctx.set(dut.i_data.payload, {"id": number, "data": 0, "response": response, "last": last})
            if ctx.get(dut.o_fault.valid):
                faults.append((Fault(ctx.get(dut.o_fault.payload.code)), ctx.get(dut.o_fault.payload.address)))
            await ctx.tick()

    simulator_of(dut, bench).run()
    return faults


def address(number):
    return FIRST[number] << MemoryFormats(CONFIG).low_bits


def test_a_time_out_has_the_address_of_the_oldest_burst():
    """Also when the last beat was of a later burst."""
    assert faults_of({5: (2, 0, 1)}) == [(Fault.READ_TIMEOUT, address(0))]


@pytest.mark.parametrize("response", [0, SLVERR, DECERR])
@pytest.mark.parametrize(("number", "last"), [(0, 1), (2, 1), (3, 0), (3, 1)])
def test_a_beat_of_a_wrong_number_is_no_mere_error(number, last, response):
    """A burst of two beats that ends with the first one, and a beat that no burst waits for: whatever memory says of
    them, the code is that of the protocol, once.
    """
    faults = faults_of({6: (number, response, last)}, length=1, cycles=12)
    assert [code for code, _ in faults] == [Fault.READ_PROTOCOL]
    assert number == 3 or faults[0][1] == address(number)


@pytest.mark.parametrize("response", [0, SLVERR])
def test_a_last_beat_that_is_not_marked_is_no_mere_error(response):
    assert faults_of({6: (1, 0, 0), 7: (1, response, 0)}, length=1, cycles=12) == [(Fault.READ_PROTOCOL, address(1))]


def test_an_error_is_one_of_its_burst():
    """Of the first and of the last beat."""
    for beats in ({6: (1, SLVERR, 0), 7: (1, 0, 1)}, {6: (1, 0, 0), 7: (1, SLVERR, 1)}):
        assert faults_of(beats, length=1, cycles=12) == [(Fault.READ_REPLY, address(1))]


@pytest.mark.parametrize(("beat", "code"), [
    ((0, SLVERR, 1), Fault.READ_REPLY), ((3, 0, 1), Fault.READ_PROTOCOL)])
def test_a_fault_beside_a_time_out(beat, code):
    """Before it and after it both are reported, in their order; in the same cycle the time-out alone."""
    seen = [[one for one, _ in faults_of({cycle: beat})] for cycle in range(16, 24)]
    same = seen.index([Fault.READ_TIMEOUT])
    assert seen == [[code, Fault.READ_TIMEOUT]] * same + [[Fault.READ_TIMEOUT]] + (
        [[Fault.READ_TIMEOUT, code]] * (len(seen) - same - 1))
