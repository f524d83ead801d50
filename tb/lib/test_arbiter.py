# amaranth: UnusedElaboratable=no

import cocotb
import pytest
from amaranth.lib.data import StructLayout
from cocotb.triggers import ClockCycles, RisingEdge

from hw.lib.arbiter import Arbiter, ArbiterPolicy
from tb.lib.clocking import reset, start
from tb.lib.no_x import assert_known
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source

MODULE = "tb.lib.test_arbiter"
SHAPE = StructLayout({"low": 4, "high": 4})
COUNT = 3
INPUTS = [f"i__{k}" for k in range(COUNT)]


def items_of(source, count):
    return [(64 * source + k) % 256 for k in range(count)]


def split(came):
    """The items of each source in the order in which they came."""
    return [[item >> 2 for item in came if item & 3 == k] for k in range(COUNT)]


async def send_all(dut, count, stalls="none"):
    """The same number of items of each source, with stalls of their own."""
    seed = options()["seed"]
    tasks = [cocotb.start_soon(Source(dut, name, stalls=STALLS[stalls](seed + k)).send(items_of(k, count)))
             for k, name in enumerate(INPUTS)]
    for task in tasks:
        await task


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Of each source all items come, in its order."""
    await start(dut, cycles=100_000)
    for source_stalls, sink_stalls in STALL_PAIRS:
        sink = Sink(dut, "o", stalls=STALLS[sink_stalls](options()["seed"]))
        await send_all(dut, 24, source_stalls)
        while len(sink.items) < 24 * COUNT:
            await RisingEdge(dut.clk)
        await ClockCycles(dut.clk, 4)
        assert_known(dut, [*INPUTS, "o"])
        assert split(sink.items) == [items_of(k, 24) for k in range(COUNT)], (source_stalls, sink_stalls)
        sink.stop()


@cocotb.test()
async def one_item_per_cycle(dut):
    """While all ask they go in turn without a gap, whatever the policy."""
    await start(dut, cycles=1000)
    sink, taken = Sink(dut, "o"), Monitor(dut, "i__0")
    await send_all(dut, 40)
    await ClockCycles(dut.clk, 4)
    assert [item & 3 for item in sink.items] == list(range(COUNT)) * 40
    assert sink.cycles == list(range(sink.cycles[0], sink.cycles[0] + 40 * COUNT))
    assert sink.cycles[0] - taken.cycles[0] == options()["latency"]


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing that was in flight comes out after a reset."""
    await start(dut, cycles=1000)
    dut.o__ready.value = 0
    sources = [Source(dut, name) for name in INPUTS]
    await sources[2].send(items_of(2, 1))
    # One item is at the output, another one asks.
    waiting = cocotb.start_soon(sources[1].send(items_of(1, 1)))
    await ClockCycles(dut.clk, 3)
    waiting.cancel()
    await reset(dut)
    sink = Sink(dut, "o")
    await send_all(dut, 8)
    await ClockCycles(dut.clk, 4)
    assert split(sink.items) == [items_of(k, 8) for k in range(COUNT)]


@cocotb.test()
async def who_came_first(dut):
    """After a wait the inputs go in the order in which they came, or in turn."""
    await start(dut, cycles=1000)
    sources = [Source(dut, name) for name in INPUTS]
    # An item of input 0 waits at the output, then inputs 2, 1 and 0 ask.
    dut.o__ready.value = 0
    await sources[0].send([255])
    tasks = []
    for k in (2, 1, 0):
        tasks.append(cocotb.start_soon(sources[k].send(items_of(k, 1))))
        await ClockCycles(dut.clk, 2)
    sink = Sink(dut, "o")
    for task in tasks:
        await task
    await ClockCycles(dut.clk, 4)
    assert [item & 3 for item in sink.items] == options()["order"]


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize(("policy", "order"), [(ArbiterPolicy.ROUND_ROBIN, [0, 1, 2, 0]),
                                               (ArbiterPolicy.LONGEST_WAITING, [0, 2, 1, 0])])
def test_in_the_simulator(policy, order, simulator):
    arbiter = Arbiter(SHAPE, count=COUNT, policy=policy)
    simulate(arbiter, MODULE, ("every_pair_of_stalls", "one_item_per_cycle", "reset_in_flight", "who_came_first"),
             simulator=simulator, name=f"arbiter-{policy.name.lower()}-{simulator}", order=order,
             latency=arbiter.latency)


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), ("2", TypeError)])
def test_init_wrong_count(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        Arbiter(SHAPE, count=count)


def test_init_wrong_policy():
    with pytest.raises(TypeError, match=r"^Policy must be an ArbiterPolicy, not 1$"):
        Arbiter(SHAPE, count=2, policy=1)
