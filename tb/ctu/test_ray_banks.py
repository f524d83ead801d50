from itertools import pairwise

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles

from golden.engine.config import PRESETS
from golden.engine.stimulus.ctu.ray_memory import SLOTS
from hw.ctu.ray_banks import RayBanks
from tb.ctu.ray_memory_bench import Rays, play, request
from tb.lib.clocking import start
from tb.lib.responder import Responder
from tb.lib.runner import SLOW_IN_ICARUS, options, simulate
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

VERSION_BITS, DEFERRED, MANY = 10, 16, 64
# Cycles from a return to the ray that leaves again.
AGAIN = 22


def make(slots):
    return RayBanks(slots=slots, version_bits=VERSION_BITS, deferred=DEFERRED, generation_bits=2, tag=16)


@cocotb.test()
async def latencies(dut):
    """Of a ray that leaves, and of one that leaves again."""
    await start(dut, cycles=2_000)
    rays = Rays(dut, returns=False)
    ports = rays.ports
    await ports.send("i_start", [0])
    await ports.send("i", [request(2, 1), request(2, 2, 7)])
    await ClockCycles(dut.clk, 20)
    assert rays.sink.cycles[0] - rays.taken.cycles[0] == documented_latency(RayBanks, PRESETS["tiny"])
    assert documented_latency(RayBanks, PRESETS["tiny"]) == make(SLOTS).latency
    back = ports.taken("i_return")
    await ports.send("i_return", [2])
    await ClockCycles(dut.clk, 2 * AGAIN)
    assert [ray["tag"] for ray in ports.came("o")] == [0, 7]
    assert rays.sink.cycles[1] - back.cycles[0] == AGAIN


@cocotb.test(skip=True)
async def a_ray_per_cycle(dut):
    """Rays leave and come back in the same cycles: in the order of their slots one per cycle, in any order nearly."""
    await start(dut, cycles=20_000)
    rays = Rays(dut, away=8)
    ports = rays.ports
    await ports.send("i_start", [0])
    random = np.random.default_rng(options()["seed"])
    for name, order, least in (("in order", np.arange(MANY), 0.999), ("mixed", random.permutation(MANY), 0.8)):
        first, times = len(rays.sink.cycles), 8
        version = 1 + times * (name == "mixed")
        await ports.send("i", [request(slot, version + k) for k in range(times) for slot in order])
        await rays.settled()
        cycles = rays.sink.cycles[first:]
        assert len(cycles) == times * MANY
        rate = (len(cycles) - 1) / (cycles[-1] - cycles[0])
        cocotb.log.info("%s: %.3f rays per cycle", name, rate)
        assert rate >= least, f"{name}: only {rate:.3f} rays per cycle"
        gaps = {b - a for a, b in pairwise(cycles)}
        assert name == "mixed" or gaps == {1}, gaps


@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_in_the_simulator(simulator):
    simulate(make(SLOTS), f"tb.ctu.ray_memory_bench,{__name__}", simulator=simulator, memory=__name__, slots=SLOTS)


@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_rate(simulator):
    simulate(make(MANY), __name__, ("a_ray_per_cycle",), simulator=simulator, memory=__name__, slots=MANY)


@pytest.mark.sim
def test_each_slot_leaves_once_for_each_shell():
    """In the order of requests, frustum after frustum, also when tags of generations run out."""
    dut = make(SLOTS)
    play(dut, dut.o_passed, slots=SLOTS, frusta=6, seed=0)


def test_a_request_before_the_begin_of_a_frustum_belongs_to_the_one_before():
    """The ray has left, and is back: it leaves again in the next frustum alone."""
    bench, both = ScheduleBench(make(SLOTS), idle_limit=60), set()
    for gap in range(34, 46):
        came = bench.run(
            Schedule(items={"i_start": [(0, 0), (gap, 0)], "i": [(20, request(2, 1)), (20, request(2, 1, 9))]}),
            Responder("o", "i_return", lambda ray: [ray["slot"]], after=3))
        before = bench.cycles["i"][1] < bench.cycles["i_start"][1]
        both.add(before)
        assert [ray["tag"] for ray in came["o"]] == ([0] if before else [0, 9])
        assert came["o_passed__0"] + came["o_passed__1"] == ([9] if before else [])
    assert both == {False, True}


@pytest.mark.parametrize("name", ["slots", "deferred"])
@pytest.mark.parametrize(("value", "requirement"), [(0, "at least 2"), (3, "a multiple of the banks")])
def test_init_wrong_size(name, value, requirement):
    sizes = {"slots": 4, "version_bits": 4, "deferred": 2, "generation_bits": 1, name: value}
    with pytest.raises(ValueError, match=f"^{name.capitalize()} must be {requirement}, not {value}$"):
        RayBanks(tag=4, **sizes)
