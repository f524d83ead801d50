"""The compiled machine: the same results as in a simulator that runs Python in each cycle, many times as fast."""

import json
import sys
import time
from pathlib import Path

import cocotb
import pytest
from cocotb.utils import get_sim_time

from hw.host import EngineError, Host
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from hw.simulator.machine_verilog import engine_verilog
from hw.simulator.register_error import RegisterError
from hw.simulator.simulated_port import SimulatedPort, complete
from tb.lib.clocking import PERIOD, start
from tb.lib.configurations import config_of
from tb.lib.runner import BUILD, options, simulate
from tb.system.job_machine import BASE, ONE_CLUSTER, SMALL
from tb.system.scenes import frusta, save
from tb.system.test_engine import Bench, third_party_memory

CHANGES = SMALL | {"noc.columns": 1}
CONFIG = config_of(CHANGES)
# Least speedup over a testbench whose memory runs Python in each cycle.
FASTER = 2


@pytest.fixture(scope="module")
def given():
    return frusta("cornell", CONFIG, cell=0.5, points=(5, 1, 2))


def port_for(given, **memory):
    return SimulatedPort(CONFIG, size=len(given[0].image.to_bytes()), base=BASE, **memory)


def cast(host, frustum, *lives):
    """Cycles of a cast that must leave what golden says."""
    complete(host.load(frustum.image, **({"lives": lives} if lives else {})))
    cycles = complete(host.cast(timeout=1 << 20))
    image = complete(host.results(total=frustum.total))
    for name in ("hits", "sums"):
        assert image[name].tobytes() == frustum.written[name].tobytes(), name
    return cycles


def test_a_driver_waits_for_its_port_only():
    class Waits:
        def __await__(self):
            yield

    async def waits():
        await Waits()

    with pytest.raises(RuntimeError, match="nothing but its port"):
        complete(waits())


@ONE_CLUSTER
def test_hits_and_sums_are_golden(given):
    for memory in ({"latency": 1}, {"latency": 10}, {"latency": 3, "spread": 30, "shuffles": True, "seed": 5}):
        with port_for(given, **memory) as port:
            host = Host(port, CONFIG, base=BASE)
            complete(host.identify())
            cast(host, given[0])
            for frustum in given[1:]:
                cast(host, frustum, "rays", "frustum")
            assert port.outside == 0
            assert port.read_beats > len(given[0].image.to_bytes()) // 16
            assert port.written_beats >= 2 * len(given[0].hits.patch)


@ONE_CLUSTER
def test_latency_costs_cycles_and_the_seed_repeats_them(given):
    def cycles(**memory):
        with port_for(given, **memory) as port:
            cast(Host(port, CONFIG, base=BASE), given[0])
            return port.cycles

    assert cycles(latency=1) < cycles(latency=10) < cycles(latency=40)
    chance = {"latency": 5, "spread": 200, "shuffles": True}
    # The host polls, so different seeds may take the same number of cycles.
    assert cycles(seed=1, **chance) == cycles(seed=1, **chance)
    assert len({cycles(seed=seed, **chance) for seed in range(1, 6)}) > 1


@ONE_CLUSTER
def test_errors_and_resets(given):
    offsets = addresses(ENGINE_REGISTERS)
    with port_for(given) as port:
        host = Host(port, CONFIG, base=BASE)
        with pytest.raises(RegisterError, match="0x1000"):
            complete(port.read(0x1000))
        with pytest.raises(RegisterError):
            complete(port.write(offsets["magic"], 1))
        with pytest.raises(ValueError, match="Memory must hold"):
            complete(port.write_memory(BASE - 1, b"00"))
        with pytest.raises(EngineError) as raised:
            complete(host.cast())
        assert raised.value.code == ErrorCode.NOT_LOADED
        # A window that is larger than memory: what is outside answers with an error.
        complete(host.write("read_limit", BASE + (1 << 30)))
        complete(host.write("image", BASE + (1 << 20)))
        complete(host.command("load"))
        with pytest.raises(EngineError) as raised:
            complete(host.finish("loads", timeout=10_000))
        assert raised.value.code == ErrorCode.READ_REPLY
        assert port.outside > 0
        for cycles in (1, 77, 900):
            complete(host.load(given[0].image))
            complete(host.start())
            complete(port.wait(cycles))
            port.reset()
            cast(host, given[0])


async def rate(bench):
    """Cycles per second of the processor of one load, cast and result, with all that wakes Python."""
    begin, before = time.process_time(), get_sim_time("ns")
    await bench.check(bench.frusta[0])
    return (get_sim_time("ns") - before) / PERIOD / (time.process_time() - begin)


@cocotb.test()
async def timed(dut):
    """With our memory model, which reads as few pins as possible, and with a third-party memory."""
    bench = Bench(dut, latency=10)
    await start(dut, cycles=options()["cycles"])
    rates = {"ours": await rate(bench)}
    third_party_memory(bench)
    rates["theirs"] = await rate(bench)
    Path(options()["result"]).write_text(json.dumps(rates))


@pytest.mark.sim
def test_many_times_as_fast(given, capsys):
    result = (BUILD / "vectors" / "simulated-port.json").resolve()
    folder = save(given[:1], BUILD / "vectors" / "engine-simulated-port")
    simulate(engine_verilog(CONFIG), "tb.system.test_simulated_port", ("timed",), name="engine-simulated-port",
             changes=CHANGES, visible=("clk", "rst", "host__*", "axi__*"), folder=str(folder), cycles=1_000_000,
             result=str(result))
    rates = json.loads(result.read_text())
    with port_for(given) as port:
        host = Host(port, CONFIG, base=BASE)
        begin, before = time.process_time(), port.cycles
        for _ in range(5):
            cast(host, given[0])
        fast = (port.cycles - before) / (time.process_time() - begin)
    with capsys.disabled():
        sys.stdout.write(f"\ncycles per second: {fast:.0f}; with Python in each {rates['theirs']:.0f} (a memory of "
                         f"cocotbext-axi) and {rates['ours']:.0f} (ours)\n")
    assert fast >= FASTER * max(rates.values())
