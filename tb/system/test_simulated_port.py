"""The compiled machine: the same results as in a simulator that runs Python in each cycle, many times as fast."""

import json
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import cocotb
import pytest
from cocotb.utils import get_sim_time

from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from radiosity.flow.host import EngineError, Host, RegisterError
from radiosity.flow.simulator.machine_verilog import cluster_verilog, top_verilog
from radiosity.flow.simulator.simulated_port import complete
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.port_monitor import PortMonitor
from tb.lib.clocking import PERIOD, start
from tb.lib.runner import BUILD, options, simulate
from tb.lib.stall_patterns import STALLS
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.memory_model import MemoryModel
from tb.system.cocotb_port import CocotbPort
from tb.system.job_machine import BASE, CONFIGS, SMALL, TWO_CLUSTERS, JobMachine, cornell, planned
from tb.system.job_memory import JobMemory

CLUSTERS = 2
CONFIG = CONFIGS[CLUSTERS]
# Least speedup over a testbench whose memory runs Python in each cycle.
FASTER = 2


@pytest.fixture(scope="module")
def job():
    return planned(CLUSTERS, cornell(CLUSTERS, cell=0.5, rays=(32, 8), points=(5, 1, 2)))


@pytest.fixture(scope="module")
def expected(job):
    return JobMemory(job)


def test_a_driver_waits_for_its_port_only():
    class Waits:
        def __await__(self):
            yield

    async def waits():
        await Waits()

    with pytest.raises(RuntimeError, match="nothing but its port"):
        complete(waits())


@TWO_CLUSTERS
def test_hits_and_sums_are_golden(job, expected):
    for memory in ({"latency": 1}, {"latency": 10}, {"latency": 3, "spread": 30, "shuffles": True, "seed": 5}):
        with JobMachine(job, expected=expected, **memory) as machine:
            machine.right()
            beat = CONFIG.memory.beat_bytes
            assert machine.port.read_beats > job.phases[0].image.size // beat
            assert machine.port.written_beats >= sum(map(len, expected.expected.memory.values())) // beat


@pytest.mark.sim
@TWO_CLUSTERS
def test_latency_costs_cycles_and_the_seed_repeats_them(job, expected):
    def cycles(**memory):
        with JobMachine(job, expected=expected, **memory) as machine:
            machine.right()
            return machine.port.cycles

    assert cycles(latency=1) < cycles(latency=10) < cycles(latency=40)
    chance = {"latency": 5, "spread": 200, "shuffles": True}
    # The host polls, so different seeds may take the same number of cycles.
    assert cycles(seed=1, **chance) == cycles(seed=1, **chance)
    assert len({cycles(seed=seed, **chance) for seed in range(1, 6)}) > 1


@TWO_CLUSTERS
def test_errors_and_resets(job, expected):
    offsets = addresses(ENGINE_REGISTERS)
    with JobMachine(job, expected=expected) as machine:
        port, host = machine.port, machine.host
        with pytest.raises(RegisterError, match="0x1000"):
            complete(port.read(0x1000))
        with pytest.raises(RegisterError):
            complete(port.write(offsets["magic"], 1))
        with pytest.raises(ValueError, match="Memory must hold"):
            complete(port.write_memory(job.base - 1024, b"00"))
        # A window that is larger than memory: what is outside answers with an error.
        machine.begin(window=(0, job.end + (1 << 30)))
        for name in "ring", "completions":
            complete(host.write(name, job.end + (1 << 20)))
        with pytest.raises(EngineError) as raised:
            machine.run(timeout=10_000)
        assert raised.value.code == ErrorCode.READ_REPLY
        assert port.outside > 0
    with JobMachine(job, expected=expected) as machine:
        for cycles in (1, 77, 900):
            machine.begin()
            machine.submit()
            complete(machine.port.wait(cycles))
            machine.port.reset()
            machine.right()


class Bench:
    """The engine in a simulator, a memory and a host, with a job."""

    def __init__(self, dut):
        self.dut = dut
        self.job = planned(CLUSTERS, cornell(CLUSTERS, cell=0.5, rays=(32, 8), points=(5, 1)))
        self.memory = JobMemory(self.job)
        self._model = MemoryModel(CONFIG, data=bytes(self.job.end - BASE), base=BASE, seed=1, latency=10)
        self._at_port = ModelAtPort(dut, self._model)
        self.port = CocotbPort(dut, self._model)
        self.host = Host(self.port, CONFIG)

    def third_party_memory(self):
        """Put a memory of cocotbext-axi in place of the model."""
        from cocotbext.axi import AxiBus, AxiRam

        self._at_port.stop()
        PortMonitor(self.dut, "axi", AxiProtocol(CONFIG))
        ram = AxiRam(AxiBus.from_prefix(self.dut, "axi", bus_separator="__"), self.dut.clk, self.dut.rst, size=1 << 20)
        for half in ram.write_if, ram.read_if:
            half.log.setLevel("WARNING")
        # Its addresses wrap.
        self.port.memory = SimpleNamespace(base=BASE - BASE % (1 << 20), data=ram.mem)
        return ram

    async def rate(self):
        """Cycles per second of the processor of a job whose results must be golden's, with all that wakes Python."""
        begin, before = time.process_time(), get_sim_time("ns")
        await self.host.begin(self.job)
        size = self.job.end - BASE
        tables = await self.port.read_memory(BASE, size)
        records = await self.host.run(self.job)
        self.memory.check(tables, await self.port.read_memory(BASE, size), records, base=BASE)
        return (get_sim_time("ns") - before) / PERIOD / (time.process_time() - begin)


@cocotb.test()
async def timed(dut):
    """With our memory model, which reads as few pins as possible, and with a third-party memory, which also stalls."""
    bench = Bench(dut)
    await start(dut, cycles=options()["cycles"])
    await bench.host.identify()
    rates = {"ours": await bench.rate()}
    ram = bench.third_party_memory()
    rates["theirs"] = await bench.rate()
    master, write, read = bench.port.master, ram.write_if, ram.read_if
    channels = (master.write_if.aw_channel, master.write_if.w_channel, master.write_if.b_channel,
                master.read_if.ar_channel, master.read_if.r_channel, write.aw_channel, write.w_channel,
                write.b_channel, read.ar_channel, read.r_channel)
    for number, regime in enumerate(STALLS):
        for k, channel in enumerate(channels):
            channel.set_pause_generator(STALLS[regime](10 * number + k))
        await bench.rate()
    Path(options()["result"]).write_text(json.dumps(rates))


@pytest.mark.sim
def test_many_times_as_fast(job, expected, capsys):
    result = (BUILD / "vectors" / "simulated-port.json").resolve()
    result.parent.mkdir(parents=True, exist_ok=True)
    simulate(top_verilog(CONFIG) + cluster_verilog(CONFIG), "tb.system.test_simulated_port", ("timed",),
             name="engine-simulated-port", changes=SMALL | {"noc.columns": CLUSTERS},
             visible=("clk", "rst", "host__*", "axi__*"), cycles=1_000_000, result=str(result))
    rates = json.loads(result.read_text())
    with JobMachine(job, expected=expected) as machine:
        begin, before = time.process_time(), machine.port.cycles
        for _ in range(5):
            machine.right()
        fast = (machine.port.cycles - before) / (time.process_time() - begin)
    with capsys.disabled():
        sys.stdout.write(f"\ncycles per second: {fast:.0f}; with Python in each {rates['theirs']:.0f} (a memory of "
                         f"cocotbext-axi) and {rates['ours']:.0f} (ours)\n")
    assert fast >= FASTER * max(rates.values())
