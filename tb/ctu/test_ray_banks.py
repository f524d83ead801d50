# amaranth: UnusedElaboratable=no

from itertools import pairwise

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.config import PRESETS
from golden.stimulus import block
from golden.stimulus.ctu.ray_memory import SLOTS
from hw.ctu.ray_banks import RayBanks
from tb.ctu.test_ray_memory import Bench, Watch, request
from tb.lib.clocking import reset, start
from tb.lib.no_x import assert_known
from tb.lib.payload import unpack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS
from tb.lib.stream import Monitor
from tb.lib.timing import documented_latency

MODULE = "tb.ctu.test_ray_banks"
STREAMS = ("i_start", "i", "i_return", "o")
DEFERRED, BANKS, MANY = 16, 2, 64
PASSED = tuple(f"o_passed__{bank}" for bank in range(BANKS))
# Cycles from a return to the ray that leaves again.
AGAIN = 22


def make(slots=SLOTS):
    return RayBanks(slots=slots, version_bits=10, deferred=DEFERRED, generation_bits=2, tag=16, banks=BANKS)


def shape(slots=SLOTS):
    return make(slots).signature.members["i"].signature.members["payload"].shape


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Each slot leaves once for each shell that was asked for, one copy at a time."""
    await start(dut, cycles=100_000)
    watch = None
    for number, (requests, sink) in enumerate(STALL_PAIRS):
        bench = Bench(dut, requests=requests, sink=sink, seed=number, passed=PASSED)
        dut.i_return__valid.value = 0
        await RisingEdge(dut.clk)
        assert_known(dut, STREAMS)
        watch = watch or Watch(dut, deferred=DEFERRED)
        await bench.frustum()
        bench.stop()
    watch.coverage.check()


@cocotb.test()
async def one_after_the_other(dut):
    """Golden's stimulus, each access when the one before it is over."""
    await start(dut, cycles=20_000)
    bench = Bench(dut, returns=False, passed=PASSED)
    of = block("ctu.ray_memory")[1]
    given = of.draw(np.random.default_rng(options()["seed"]), 200, PRESETS["tiny"])
    wanted = of.expect(given, PRESETS["tiny"])
    await bench.start.send([0])
    for number, completes in enumerate(given["completes"].tolist()):
        slot, came = int(given["slot"][number]), len(bench.sink.items)
        if completes:
            await bench.back.send([slot])
        elif wanted["looked_at"][number]:
            await bench.request.send([request(slot, given["shell"][number], given["subshell"][number])])
        else:
            continue
        await ClockCycles(dut.clk, 2 * AGAIN + 2)
        left = [unpack(shape(), item) for item in bench.sink.items[came:]]
        expected = [{"slot": slot, "version": int(wanted["leaves_shell"][number]),
                     "tag": int(wanted["leaves_subshell"][number])}] if wanted["leaves"][number] else []
        assert left == expected, number
        assert int(dut.waiting.value) == wanted["waiting"][number]


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes out, whatever was in flight."""
    await start(dut, cycles=20_000)
    for number, cut in enumerate((1, 3, 6, 9, 14, 33)):
        bench = Bench(dut, seed=number, passed=PASSED)
        await bench.start.send([0])
        sending = cocotb.start_soon(bench.request.send(request(k % 3, 1 + k // 3) for k in range(40)))
        await ClockCycles(dut.clk, cut)
        sending.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut, seed=number, passed=PASSED)
        await ClockCycles(dut.clk, 2 * AGAIN)
        assert not bench.sink.items
        assert not int(dut.waiting.value)
        await bench.frustum(shells=3)
        bench.stop()


@cocotb.test()
async def latencies(dut):
    """Of a ray that leaves, and of one that leaves again."""
    await start(dut, cycles=2_000)
    bench = Bench(dut, returns=False, passed=PASSED)
    await bench.start.send([0])
    await bench.request.send([request(2, 1), request(2, 2, 7)])
    await ClockCycles(dut.clk, 20)
    assert bench.sink.cycles[0] - bench.taken.cycles[0] == documented_latency(RayBanks, PRESETS["tiny"])
    assert documented_latency(RayBanks, PRESETS["tiny"]) == make().latency
    back = Monitor(dut, "i_return")
    await bench.back.send([2])
    await ClockCycles(dut.clk, 2 * AGAIN)
    assert [unpack(shape(), item)["tag"] for item in bench.sink.items] == [0, 7]
    assert bench.sink.cycles[1] - back.cycles[0] == AGAIN


@cocotb.test()
async def a_ray_per_cycle(dut):
    """Rays leave and come back in the same cycles: in the order of their slots one per cycle, in any order nearly."""
    await start(dut, cycles=20_000)
    bench = Bench(dut, slots=MANY, shape=shape(MANY), passed=PASSED, away=8)
    await bench.start.send([0])
    random = np.random.default_rng(options()["seed"])
    for name, order, least in (("in order", np.arange(MANY), 0.999), ("mixed", random.permutation(MANY), 0.8)):
        first, times = len(bench.sink.cycles), 8
        version = 1 + times * (name == "mixed")
        await bench.request.send(request(slot, version + k, 0, shape(MANY)) for k in range(times) for slot in order)
        await bench.settled()
        cycles = bench.sink.cycles[first:]
        assert len(cycles) == times * MANY
        rate = (len(cycles) - 1) / (cycles[-1] - cycles[0])
        cocotb.log.info("%s: %.3f rays per cycle", name, rate)
        assert rate >= least, f"{name}: only {rate:.3f} rays per cycle"
        gaps = {b - a for a, b in pairwise(cycles)}
        assert name == "mixed" or gaps == {1}, gaps


ALL = ("every_pair_of_stalls", "one_after_the_other", "reset_in_flight", "latencies")


@pytest.mark.parametrize("simulator", [SIMULATORS[0], pytest.param("icarus", marks=pytest.mark.nightly)])
def test_in_the_simulator(simulator):
    simulate(make(), MODULE, ALL, simulator=simulator, name=f"ctu_ray_banks-{simulator}")


@pytest.mark.parametrize("simulator", [SIMULATORS[0], pytest.param("icarus", marks=pytest.mark.nightly)])
def test_rate(simulator):
    simulate(make(MANY), MODULE, ("a_ray_per_cycle",), simulator=simulator, name=f"ctu_ray_banks_rate-{simulator}")


@pytest.mark.parametrize(("name", "value", "error", "message"), [
    ("slots", 0, ValueError, "Slots must be at least 2"), ("slots", 2.0, TypeError, "Slots must be at least 2"),
    ("slots", 3, ValueError, "Slots must be a multiple of the banks"),
    ("deferred", 0, ValueError, "Deferred must be at least 2"),
    ("deferred", 3, ValueError, "Deferred must be a multiple of the banks"),
    ("deferred", 2.0, TypeError, "Deferred must be at least 2"),
    ("banks", 0, ValueError, "Banks must be a power of two, at least 2"),
    ("banks", 3, ValueError, "Banks must be a power of two, at least 2"),
    ("banks", 2.0, TypeError, "Banks must be a power of two, at least 2")])
def test_init_wrong_size(name, value, error, message):
    sizes = {"slots": 4, "version_bits": 4, "deferred": 2, "generation_bits": 1, "banks": 2, name: value}
    with pytest.raises(error, match=f"^{message}, not {value!r}$"):
        RayBanks(tag=4, **sizes)
