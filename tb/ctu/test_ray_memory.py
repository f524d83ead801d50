import cocotb
import pytest
from cocotb.triggers import ClockCycles

from golden.engine.config import PRESETS
from golden.engine.stimulus.ctu.ray_memory import SLOTS
from hw.ctu.ray_memory import RayMemory
from tb.ctu.ray_memory_bench import Rays, check_rate, play, request
from tb.lib.clocking import start
from tb.lib.runner import SLOW_IN_ICARUS, simulate
from tb.lib.simulator import simulator_of
from tb.lib.timing import documented_latency

VERSION_BITS, DEFERRED, GENERATION_BITS = 10, 8, 2
# Cycles from a return to the ray that leaves again.
AGAIN = 21


def make(slots):
    return RayMemory(slots=slots, version_bits=VERSION_BITS, deferred=DEFERRED, generation_bits=GENERATION_BITS, tag=16)


@cocotb.test()
async def one_access_per_cycle(dut):
    """Requests are taken and rays leave one per cycle, after the latencies that the docstring states."""
    await start(dut, cycles=2_000)
    rays = Rays(dut, returns=False)
    ports = rays.ports
    await ports.send("i_start", [0])
    await ports.send("i", [request(k, 5, k) for k in range(SLOTS)])
    await ClockCycles(dut.clk, 14)
    check_rate(rays.taken.cycles, "requests must be taken")
    check_rate(rays.sink.cycles, "rays must leave")
    assert rays.sink.cycles[0] - rays.taken.cycles[0] == documented_latency(RayMemory, PRESETS["tiny"])
    # The same again are dropped at that rate; later ones wait.
    taken, left = len(rays.taken.cycles), len(rays.sink.cycles)
    await ports.send("i", [request(k, 5) for k in range(SLOTS)])
    await ports.send("i", [request(k, 6, k) for k in range(min(SLOTS, DEFERRED))])
    await ClockCycles(dut.clk, 14)
    assert len(rays.sink.cycles) == left
    assert ports["waiting"] == min(SLOTS, DEFERRED)
    check_rate(rays.taken.cycles[taken:taken + SLOTS], "requests must be dropped")
    # Rays come back, one per cycle, and leave again so.
    back = ports.taken("i_return")
    await ports.send("i_return", range(min(SLOTS, DEFERRED)))
    await ClockCycles(dut.clk, 2 * AGAIN)
    again = rays.sink.cycles[left:]
    assert len(again) == min(SLOTS, DEFERRED)
    check_rate(back.cycles, "returns must be taken")
    check_rate(again, "those that waited must leave")


@cocotb.test()
async def a_return_to_one_request(dut):
    """The ray leaves again after the latency that the docstring states; a full store stalls requests only."""
    await start(dut, cycles=2_000)
    rays = Rays(dut, returns=False)
    ports = rays.ports
    await ports.send("i_start", [0])
    await ports.send("i", [request(2, 1), *(request(2, 2 + k, k) for k in range(DEFERRED))])
    await ClockCycles(dut.clk, 14)
    assert ports["waiting"] == DEFERRED
    stuck = ports.begin("i", [request(3, 1, 77)])
    await ClockCycles(dut.clk, 14)
    assert not stuck.done()
    back = ports.taken("i_return")
    for k in range(DEFERRED):
        left = len(rays.sink.items)
        await ports.send("i_return", [2])
        await ClockCycles(dut.clk, 2 * AGAIN)
        came = ports.came("o", left)
        assert [ray for ray in came if ray["slot"] == 2] == [{"slot": 2, "version": 2 + k, "tag": k}]
        assert rays.sink.cycles[left] - back.cycles[-1] == AGAIN
    assert stuck.done()


@cocotb.test()
async def returns_block_retries(dut):
    """First come, first served: also if the ray is back while returns block those behind the one that it left for."""
    await start(dut, cycles=100_000)
    others = SLOTS - 1
    for begin in range(AGAIN + 2):
        for until in range(begin + 2, AGAIN + 14, 4):
            rays = Rays(dut, returns=False)
            ports = rays.ports
            await ports.send("i_start", [0])
            await ports.send("i", [request(0, 1), *(request(1 + k, 1) for k in range(others)),
                                      *(request(0, 2 + k, k) for k in range(DEFERRED))])
            await ClockCycles(dut.clk, AGAIN)
            assert ports["waiting"] == DEFERRED
            seen, left = len(rays.sink.items), []
            idle, cycle = 0, -1
            while idle < 2 * AGAIN:
                # The hot slot's ray comes back at once; a return of another slot's ray does not change its slot.
                came = ports.came("o", seen)
                seen += len(came)
                left += [ray["tag"] for ray in came]
                back = cycle < 0 or bool(came)
                dut.i_return__valid.value = back or begin <= cycle < until
                dut.i_return__payload.value = 0 if back else 1 + cycle % others
                cycle, idle = cycle + 1, 0 if back or cycle < until else idle + 1
                await rays.edge
            assert left == list(range(DEFERRED)), (begin, until)
            ports.stop()


@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_in_the_simulator(simulator):
    simulate(make(SLOTS), f"tb.ctu.ray_memory_bench,{__name__}", simulator=simulator, memory=__name__, slots=SLOTS)


@pytest.mark.sim
def test_each_slot_leaves_once_for_each_shell():
    """In the order of requests, frustum after frustum, also when tags of generations run out."""
    dut = make(SLOTS)
    play(dut, [dut.o_passed], slots=SLOTS, frusta=9, seed=1)


def test_requests_wait_for_a_slot_again_and_again_in_one_frustum():
    """Each ray that is back leaves for the request that has waited longest, also when others have waited before."""
    dut, left, rounds = make(2), [], 3

    async def bench(ctx):
        async def idle(cycles):
            for _ in range(cycles):
                if ctx.get(dut.o.valid):
                    left.append((ctx.get(dut.o.payload.version), ctx.get(dut.o.payload.tag)))
                await ctx.tick()

        async def give(stream):
            ctx.set(stream.valid, 1)
            while not ctx.get(stream.ready):
                await idle(1)
            await idle(1)
            ctx.set(stream.valid, 0)

        ctx.set(dut.o.ready, 1)
        await give(dut.i_start)
        for number in range(rounds):
            # The first one leaves at once, the others wait for its return. The last one's version comes twice: dropped.
            first = 1 + 3 * number
            for version in (first, first + 1, first + 2, first + 2):
                ctx.set(dut.i.payload, request(1, version, 100 + version))
                await give(dut.i)
                if version == first:
                    await idle(dut.latency)
                    assert left[-1][0] == first
            await idle(2 * AGAIN)
            assert ctx.get(dut.waiting) == 3
            ctx.set(dut.i_return.payload, 1)
            for _ in range(3):
                await give(dut.i_return)
                await idle(2 * AGAIN)
            assert ctx.get(dut.waiting) == 0

    simulator_of(dut, bench).run()
    assert left == [(version, 100 + version) for version in range(1, 1 + 3 * rounds)]


@pytest.mark.parametrize(("name", "message"), [
    ("slots", "Slots"), ("version_bits", "Version bits"), ("deferred", "Deferred"),
    ("generation_bits", "Generation bits")])
def test_init_wrong_size(name, message):
    sizes = {"slots": 4, "version_bits": 4, "deferred": 2, "generation_bits": 1, name: 0}
    with pytest.raises(ValueError, match=f"^{message} must be at least 1, not 0$"):
        RayMemory(tag=4, **sizes)
