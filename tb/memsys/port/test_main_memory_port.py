from itertools import pairwise

import cocotb
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.base.errors import InputError
from hw.memsys.port.fault import Fault
from hw.memsys.port.main_memory_port import MainMemoryPort
from hw.memsys.port.read_engine import ReadEngine
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.runner import SLOW_IN_ICARUS, options, simulate
from tb.lib.stall_patterns import STALLS, stall_pairs
from tb.lib.stream import Monitor
from tb.lib.timing import documented_latency
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.memory_model import MemoryModel
from tb.memsys.port.port_bench import BASE, READ, SMALL, STREAMS, TAG, WRITE, Bench, content


def memory(bench, **more):
    return MemoryModel(bench.config, content(), base=BASE, seed=bench.seed, **more)


@cocotb.test()
async def out_of_order_under_every_pair_of_stalls(dut):
    """Beats of different bursts in any order, all channels with stalls of their own."""
    await start(dut, cycles=200_000)
    for number, (source, sink) in enumerate(stall_pairs()):
        bench = Bench(dut, source, sink)
        names = [*STALLS][:4]
        stalls = {channel: names[(number + k) % 4] for k, channel in enumerate(("ar", "aw", "w", "r", "b"))}
        model = memory(bench, latency=3, spread=30, shuffles=True, stalls=stalls)
        port = ModelAtPort(dut, model)
        if not number:
            await RisingEdge(dut.clk)
            assert_known(dut, STREAMS)
        after = await bench.exchange(model, 6)
        assert model.data == after
        assert bench.fault()[0] is Fault.NONE
        port.stop()
        bench.stop()


@cocotb.test()
async def errors_from_memory(dut):
    """Beats that memory answers with an error: their bursts are errors, the others are not."""
    await start(dut, cycles=60_000)
    bench = Bench(dut, sink="random")

    def failed(address):
        return address // bench.bytes % 37 == 5

    model = memory(bench, latency=5, spread=10, shuffles=True, fails=failed)
    port = ModelAtPort(dut, model)
    await bench.exchange(model, 40, failed)
    code, address = bench.fault()
    assert code in (Fault.READ_REPLY, Fault.WRITE_REPLY)
    bursts = model.reads if code is Fault.READ_REPLY else model.writes
    assert any(first == address and any(failed(first + k * bench.bytes) for k in range(beats))
               for first, beats in bursts), f"no burst at {address:#x} failed"
    await bench.clear()
    port.stop()


@cocotb.test()
async def outside_the_windows(dut):
    """No transaction is issued, and everything is answered, in order with what lies inside."""
    await start(dut, cycles=60_000)
    bench = Bench(dut, sink="random")
    top, beat = 1 << bench.config.memory.address_bits, bench.bytes
    for is_write, (low, high) in (False, READ), (True, WRITE):
        model = memory(bench, latency=4)
        port = ModelAtPort(dut, model)
        outside = [(low - beat, 1), (low - beat, 2), (high, 1), (high - beat, 2), (low + 1, 1), (high - 1, 1), (0, 4),
                   (low - 64, 64), (top - beat, 1), (top - beat, 64), (top - 16 * beat, 17), (high + beat // 2, 1)]
        requests, bad = [], []
        for address, beats in outside:
            requests += [{"address": address, "length": beats - 1, "tag": 9}, bench.request((low, high), beats=2)]
            bad += [True, False]
        after = bytearray(model.data)
        source, sink = (bench.writes, bench.written) if is_write else (bench.reads, bench.replies)
        task = bench.start(source, requests)
        if is_write:
            beats = []
            for request, is_bad in zip(requests, bad, strict=True):
                dropped = [{"data": 1, "strobe": (1 << bench.bytes) - 1}] * (request["length"] + 1)
                beats += dropped if is_bad else bench.to_write([request], after)
            await bench.send(bench.data, beats)
            expected = [{"tag": request["tag"], "error": is_bad} for request, is_bad in zip(requests, bad, strict=True)]
        else:
            expected = []
            for request, is_bad in zip(requests, bad, strict=True):
                expected += [{"data": 0, "tag": 9, "error": True, "last": k == request["length"]} for k in range(
                    request["length"] + 1)] if is_bad else bench.expected(request, model.data)
        await bench.arrive(sink, len(expected))
        await task
        bench.compare(sink, expected)
        assert model.data == after
        bursts = model.writes if is_write else model.reads
        assert len(bursts) >= len(outside)
        assert all(low <= first and first + beats * beat <= high for first, beats in bursts)
        code = Fault.WRITE_OUTSIDE if is_write else Fault.READ_OUTSIDE
        assert bench.fault() == (code, outside[0][0])
        await bench.clear()
        port.stop()


@cocotb.test()
async def wrong_lengths(dut):
    """Too few or too many beats make their burst an error, and no other one."""
    await start(dut, cycles=60_000)
    bench = Bench(dut)
    model = memory(bench, latency=3)
    port = ModelAtPort(dut, model)
    beats = bench.config.memory.burst_beats
    for cut in (1, beats - 1, -1, -5):
        requests = [bench.request((READ[0], WRITE[0]), beats=1) for _ in range(3)]
        requests[1] = {"address": BASE + 0x800, "length": beats - 1, "tag": 5}
        bench.replies.items.clear()
        await bench.send(bench.reads, requests[:1])
        await bench.arrive(bench.replies, 1)
        model.silent.add("r")
        await bench.send(bench.reads, requests[1:2])
        while not model.outstanding_reads:
            await RisingEdge(dut.clk)
        model.cut(cut)
        model.silent.clear()
        await bench.send(bench.reads, requests[2:])
        await bench.arrive(bench.replies, beats + 2)
        bench.compare(bench.replies, [
            *bench.expected(requests[0], model.data), *bench.expected(requests[1], model.data, lambda address: True),
            *bench.expected(requests[2], model.data)])
        assert bench.fault() == (Fault.READ_PROTOCOL, requests[1]["address"])
        await bench.clear()
    port.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """After a reset of machine and memory nothing of before comes out."""
    await start(dut, cycles=100_000)
    for cycles in (4, 9, 17, 30, 55, 71, 140, 333):
        bench = Bench(dut, sink="random")
        model = memory(bench, latency=9, spread=20, shuffles=True)
        port = ModelAtPort(dut, model)
        task = cocotb.start_soon(bench.exchange(model, 30))
        await ClockCycles(dut.clk, cycles)
        assert int(dut.busy.value)
        task.cancel()
        port.stop()
        bench.stop()
        await reset(dut)
        bench = Bench(dut)
        model = memory(bench, latency=2)
        port = ModelAtPort(dut, model)
        assert await bench.exchange(model, 2) == model.data
        port.stop()
        bench.stop()


@cocotb.test()
async def busy_until_all_is_answered(dut):
    """From the cycle after a request on, with reads alone and with writes alone."""
    await start(dut, cycles=10_000)
    for given, answer, size in (("i_read", "o_read", 8), ("i_write", "o_written", 1)):
        bench = Bench(dut)
        port = ModelAtPort(dut, memory(bench, latency=9))
        requests = [bench.request(WRITE, beats=8) for _ in range(3)]
        in_flight, left = 0, size * len(requests)
        if given == "i_read":
            bench.start(bench.reads, requests)
        else:
            bench.start(bench.writes, requests)
            bench.start(bench.data, bench.to_write(requests, bytearray(content())))
        while left or in_flight:
            await RisingEdge(dut.clk)
            assert int(dut.busy.value) == (in_flight > 0), given
            for name, items in (given, size), (answer, -1):
                if int(getattr(dut, f"{name}__valid").value) and int(getattr(dut, f"{name}__ready").value):
                    in_flight, left = in_flight + items, left - max(0, items)
        await RisingEdge(dut.clk)
        assert not int(dut.busy.value)
        port.stop()
        bench.stop()


@cocotb.test()
async def busy_until_the_data_of_an_error_have_come(dut):
    """A write outside the window is answered before its data are there; they are accepted and discarded."""
    await start(dut, cycles=10_000)
    bench = Bench(dut)
    model = memory(bench)
    port = ModelAtPort(dut, model)
    # A burst of its own: one that follows another's data is answered after them.
    count = bench.config.memory.burst_beats
    size = count * bench.bytes
    request = bench.request(WRITE, beats=count) | {"address": -(-WRITE[1] // size) * size}
    await bench.send(bench.writes, [request])
    await bench.arrive(bench.written, 1)
    bench.compare(bench.written, [{"tag": request["tag"], "error": True}])
    for beats in count - 1, 1:
        assert int(dut.busy.value)
        await bench.send(bench.data, [{"data": 0, "strobe": (1 << bench.bytes) - 1}] * beats)
        await ClockCycles(dut.clk, 3)
    assert not int(dut.busy.value)
    assert not model.writes
    port.stop()
    bench.stop()


@cocotb.test()
async def a_slow_client_is_no_time_out(dut):
    """Wherever in a burst it stalls."""
    await start(dut, cycles=20_000)
    bench = Bench(dut)
    model = memory(bench, latency=5)
    port = ModelAtPort(dut, model)
    for first in (0, 1, 5):
        request, after = bench.request(WRITE, beats=8), bytearray(model.data)
        beats = bench.to_write([request], after)
        bench.written.items.clear()
        await bench.send(bench.writes, [request])
        await bench.send(bench.data, beats[:first])
        await ClockCycles(dut.clk, 3 << bench.config.memory.timeout_bits)
        await bench.send(bench.data, beats[first:])
        await bench.arrive(bench.written, 1)
        bench.compare(bench.written, [{"tag": request["tag"], "error": False}])
        assert (bench.fault()[0], model.data) == (Fault.NONE, after)
    port.stop()
    bench.stop()


@cocotb.test()
async def unrequested_beats_are_no_progress(dut):
    """A read that memory does not answer times out while memory sends beats that no read waits for."""
    await start(dut, cycles=10_000)
    bench = Bench(dut)
    limit = 1 << bench.config.memory.timeout_bits
    model = memory(bench, latency=100 * limit)
    port = ModelAtPort(dut, model)
    request = bench.request(READ, beats=1)
    await bench.send(bench.reads, [request])
    for _ in range(12):
        model.inject(rid=1)
        await ClockCycles(dut.clk, limit // 4)
    bench.compare(bench.replies, bench.expected(request, model.data, lambda address: True))
    port.stop()
    bench.stop()


@cocotb.test()
async def an_answer_before_the_address(dut):
    """A memory that has accepted data and not their address cannot have written them."""
    await start(dut, cycles=2000)
    bench = Bench(dut)
    dut.axi__wready.value = 1
    request = bench.request(WRITE, beats=1)
    await bench.send(bench.writes, [request])
    await bench.send(bench.data, bench.to_write([request], bytearray(content())))

    async def answer():
        await ClockCycles(dut.clk, 5)
        dut.axi__bvalid.value = 1
        await RisingEdge(dut.clk)
        while not int(dut.axi__bready.value):
            await RisingEdge(dut.clk)
        dut.axi__bvalid.value = 0
        await ClockCycles(dut.clk, 5)

    await answer()
    assert bench.fault()[0] is Fault.WRITE_PROTOCOL
    assert not bench.written.items
    await bench.clear()
    dut.axi__awready.value = 1
    await answer()
    bench.compare(bench.written, [{"tag": request["tag"], "error": False}])
    bench.stop()


@cocotb.test()
async def latency(dut):
    """From a request to its address, and from a beat to the reply."""
    await start(dut, cycles=1000)
    bench = Bench(dut)
    port = ModelAtPort(dut, memory(bench, latency=7))
    seen = {}
    bench.start(bench.reads, [{"address": READ[0], "length": 0, "tag": 1}])
    for cycle in range(60):
        await RisingEdge(dut.clk)
        for name in ("i_read__valid", "axi__arvalid", "axi__rvalid", "o_read__valid"):
            if int(getattr(dut, name).value):
                seen.setdefault(name, cycle)
    given, requested, came, replied = seen.values()
    assert [requested - given, replied - came] == options()["latencies"]
    port.stop()


@cocotb.test()
async def a_beat_per_cycle(dut):
    """A memory of 50 cycles is hidden by as many bursts as that takes; writes go out without a gap."""
    await start(dut, cycles=60_000)
    count, beats = 8, 64
    requests = [{"address": WRITE[0], "length": beats - 1, "tag": k} for k in range(count)]
    for cycles in (1, 50):
        bench = Bench(dut)
        port = ModelAtPort(dut, memory(bench, latency=cycles))
        await bench.send(bench.reads, requests)
        await bench.arrive(bench.replies, count * beats)
        assert {b - a for a, b in pairwise(bench.replies.cycles)} == {1}, f"{cycles} cycles are not hidden"
        sent = Monitor(dut, "i_write_data")
        task = bench.start(bench.writes, requests)
        await bench.send(bench.data, [{"data": k, "strobe": 255} for k in range(count * beats)])
        await task
        await bench.arrive(bench.written, count)
        assert {b - a for a, b in pairwise(sent.cycles)} == {1}, "writes must go out without a gap"
        sent.stop()
        port.stop()
        bench.stop()


ALL = ("out_of_order_under_every_pair_of_stalls", "errors_from_memory", "outside_the_windows", "wrong_lengths",
       "reset_in_flight", "busy_until_all_is_answered", "busy_until_the_data_of_an_error_have_come",
       "a_slow_client_is_no_time_out", "an_answer_before_the_address", "latency")
# Sixteen bursts of eight beats, and a slot each.
MANY = {"memory.outstanding": 16}


def run(name, changes, simulator, tests=ALL):
    changes = {**SMALL, **changes}
    component = MainMemoryPort(config=config_of(changes), tag=TAG)
    assert component.latency == documented_latency(MainMemoryPort, config_of(changes))
    simulate(component, __name__, tests, simulator=simulator, name=name, changes=changes,
             latencies=[component.latency, ReadEngine(config=config_of(changes), tag=TAG).latency])


@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_the_port(simulator):
    run(f"main_memory_port-{simulator}", MANY, simulator,
        (*ALL, "unrequested_beats_are_no_progress", "a_beat_per_cycle"))


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("sizes", [
    *({"data_bits": bits} for bits in (128, 256, 512)), {"outstanding": 1, "burst_beats": 2},
    {"outstanding": 2, "burst_beats": 64}], ids=str)
def test_other_sizes(sizes):
    run(f"main_memory_port-{'-'.join(map(str, sizes.values()))}",
        {f"memory.{name}": value for name, value in sizes.items()}, "icarus")


@pytest.mark.parametrize("outstanding", [0, 3, 128])
def test_init_wrong_outstanding(outstanding):
    with pytest.raises(InputError, match=r"Outstanding \(memory.outstanding\) must be "):
        config_of({"memory.outstanding": outstanding})
