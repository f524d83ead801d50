"""Main memory's rate: beats per cycle of the memory port against the memory's latency and the outstanding bursts.

Requests for reads follow each other without a stall, memory delivers a beat per cycle after its latency, and the port
is simulated in Amaranth's own simulator. The second table has the bound: a burst occupies a slot until memory answers,
while its beats arrive and leave, and for two more cycles.
"""

from amaranth.hdl import Const
from amaranth.sim import Simulator

from benchmarks.report import benchmark, provenance, table, write_report
from golden.engine.config import PRESETS
from hw.memsys.port.main_memory_port import MainMemoryPort
from radiosity.cli.console import console

__all__ = ["bound", "main", "rate"]

LATENCIES = (1, 5, 10, 20, 50, 100, 200)
OUTSTANDING = (1, 2, 4, 8, 16)
# A burst is 64 bytes: a patch.
BURST_BEATS = 8
BEATS = 512
_TAG, _BASE = 1, 0x1000


def rate(outstanding: int, latency: int, *, beats: int = BEATS) -> float:
    """Beats per cycle in the second half of a long read."""
    config = PRESETS["paper"].replace({"memory.outstanding": outstanding, "memory.burst_beats": BURST_BEATS,
                                       "memory.length_bits": 6, "memory.timeout_bits": 12})
    port = MainMemoryPort(config=config, tag=_TAG)
    most = 1 << config.memory.length_bits
    count = 1 + beats // most
    arrivals, due, cycle = [], [], [0]

    async def client(ctx):
        ctx.set(port.read_window, {"base": _BASE, "limit": _BASE + (1 << 16)})
        ctx.set(port.o_read.ready, 1)
        ctx.set(port.i_read.payload, {"address": _BASE, "length": most - 1, "tag": 0})
        ctx.set(port.i_read.valid, 1)
        for _ in range(count):
            await ctx.tick().until(port.i_read.ready)
        ctx.set(port.i_read.valid, 0)

    async def memory(ctx):
        axi = port.axi
        ctx.set(axi.arready, 1)
        async for *_, requested, slot, length, taken, valid in ctx.tick().sample(
                axi.arvalid, axi.arid, axi.arlen, axi.rready & axi.rvalid, port.o_read.valid & Const(1)):
            cycle[0] += 1
            if valid:
                arrivals.append(cycle[0])
            if len(arrivals) == count * most:
                return
            if requested:
                due.append([cycle[0] + latency - 1, slot, length + 1])
            if taken or not ctx.get(axi.rvalid):
                ready = bool(due) and due[0][0] <= cycle[0]
                ctx.set(axi.rvalid, ready)
                if ready:
                    due[0][2] -= 1
                    ctx.set(axi.rid, due[0][1])
                    ctx.set(axi.rlast, due[0][2] == 0)
                    if not due[0][2]:
                        due.pop(0)

    simulator = Simulator(port)
    simulator.add_clock(1e-8)
    simulator.add_testbench(client, background=True)
    simulator.add_testbench(memory)
    simulator.run()
    # Whole rounds of all slots, after the first beats, which waited for nothing.
    middle, period = len(arrivals) // 2, outstanding * BURST_BEATS
    span = (len(arrivals) - 1 - middle) // period * period
    return span / (arrivals[middle + span] - arrivals[middle])


def bound(outstanding: int, latency: int) -> float:
    """Beats per cycle if a slot is occupied again as soon as its burst has left."""
    return min(1.0, outstanding * BURST_BEATS / (latency + 2 * BURST_BEATS + 2))


@benchmark("main_memory")
def main() -> None:
    """Measure how many bursts must be outstanding to hide main memory's latency."""
    rows = []
    for outstanding in OUTSTANDING:
        rows.append([outstanding, *(f"{rate(outstanding, latency):.3f}" for latency in LATENCIES)])
        console().note(f"{outstanding} outstanding bursts: {', '.join(rows[-1][1:])}")
    head = ["outstanding bursts", *(f"{latency} cycles" for latency in LATENCIES)]
    bounds = [[outstanding, *(f"{bound(outstanding, latency):.3f}" for latency in LATENCIES)]
              for outstanding in OUTSTANDING]
    write_report(
        "Main memory: beats per cycle",
        f"{provenance('amaranth')}; beats of 64 bits, bursts of {BURST_BEATS} beats (a patch), reads without a stall "
        "from a memory that delivers a beat per cycle after its latency.",
        "## Measured", table(head, rows), "## Bound", table(head, bounds))
