"""The engine's three clocks: a small unit stands for the engine between its crossings."""

import random

import pytest
from amaranth.hdl import ClockDomain, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

import hw.async_engine
from golden.config import PRESETS
from hw.async_engine import HELD, AsyncEngine
from hw.memsys.axi_signature import AxiSignature
from hw.registers.axi_lite_signature import AxiLiteSignature
from hw.registers.engine_registers import ADDRESS_BITS
from hw.registers.register import Access, Register, addresses
from hw.registers.registers import Registers
from tb.lib.seed import SEED

CONFIG = PRESETS["tiny"]
TABLE = (Register(name="address", access=Access.WRITE, about="Is read from main memory when it changes."),
         Register(name="found", access=Access.READ, about="What came."),
         Register(name="interrupt", access=Access.WRITE, about="The pin.", width=1))
PLACES = addresses(TABLE)
# Nanoseconds of a cycle of the engine, main memory and the host.
PERIODS = [(10, 7, 13), (5, 17, 3), (10, 10, 10)]
RESETS = ("engine", "memory", "host")
WATCHDOG = 500


class Reader(wiring.Component):
    """Reads the word of main memory at the address in its first register."""

    def __init__(self, *, config, black_boxes):
        super().__init__({"host": In(AxiLiteSignature(address_bits=ADDRESS_BITS)),
                          "axi": Out(AxiSignature(config=config)), "irq": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.registers = registers = Registers(TABLE, address_bits=ADDRESS_BITS)
        wiring.connect(m, wiring.flipped(self.host), registers.host)
        requested = Signal(32)
        m.d.comb += [self.axi.arvalid.eq(registers.address != requested), self.axi.araddr.eq(registers.address),
                     self.axi.rready.eq(1), self.irq.eq(registers.interrupt)]
        with m.If(self.axi.arvalid & self.axi.arready):
            m.d.sync += requested.eq(registers.address)
        with m.If(self.axi.rvalid):
            m.d.sync += registers.found.eq(self.axi.rdata)
        return m


class Machine:
    """An `AsyncEngine` around a `Reader`, a host, and a main memory that answers three times the address.

    Members
    -------
    is_slow
        Main memory takes no addresses.
    taken
        Addresses that it has taken.
    """

    def __init__(self, monkeypatch, periods):
        monkeypatch.setattr(hw.async_engine, "Engine", Reader)
        self.dut, self.is_slow, self.taken = AsyncEngine(config=CONFIG), False, []
        self.edges = {name: ClockDomain(f"edges_{name}", reset_less=True) for name in RESETS}
        self.sync = ClockDomain("sync")
        m = Module()
        m.submodules.dut = self.dut
        m.domains += [self.sync, *self.edges.values()]
        clocks = {"engine": self.sync.clk, "memory": self.dut.m_axi_aclk, "host": self.dut.s_axil_aclk}
        for name, domain in self.edges.items():
            m.d.comb += clocks[name].eq(domain.clk)
        self.simulator = Simulator(m)
        draw = random.Random(SEED)
        for domain, period in zip(self.edges.values(), periods, strict=True):
            self.simulator.add_clock(period * 1e-9, phase=draw.random() * period * 1e-9, domain=domain.name)

    async def tick(self, ctx, name, cycles=1):
        for _ in range(cycles):
            await ctx.tick(f"edges_{name}")

    def reset(self, ctx, name, is_on):
        """Drive one of the resets."""
        signal, active = {"engine": (self.sync.rst, 1), "memory": (self.dut.m_axi_aresetn, 0),
                          "host": (self.dut.s_axil_aresetn, 0)}[name]
        ctx.set(signal, active if is_on else 1 - active)

    def begin(self, ctx):
        """All resets end."""
        for name in RESETS:
            self.reset(ctx, name, False)

    async def until(self, ctx, name, signal):
        for _ in range(WATCHDOG):
            _, _, found = await ctx.tick(f"edges_{name}").sample(signal)
            if found:
                return
        raise AssertionError(f"{signal.name} stays 0")

    async def write(self, ctx, name, value):
        host = self.dut.host
        for pin, number in (("awaddr", PLACES[name]), ("wdata", value), ("wstrb", 15), ("bready", 1)):
            ctx.set(getattr(host, pin), number)
        for channel in "aw", "w":
            ctx.set(getattr(host, f"{channel}valid"), 1)
            await self.until(ctx, "host", getattr(host, f"{channel}ready"))
            ctx.set(getattr(host, f"{channel}valid"), 0)
        await self.until(ctx, "host", host.bvalid)

    async def read(self, ctx, name):
        host = self.dut.host
        ctx.set(host.araddr, PLACES[name])
        ctx.set(host.rready, 1)
        ctx.set(host.arvalid, 1)
        await self.until(ctx, "host", host.arready)
        ctx.set(host.arvalid, 0)
        for _ in range(WATCHDOG):
            _, _, valid, data = await ctx.tick("edges_host").sample(host.rvalid, host.rdata)
            if valid:
                return data
        raise AssertionError("no answer to a read")

    async def found(self, ctx, address):
        """The engine has read the word at an address."""
        for _ in range(WATCHDOG):
            if await self.read(ctx, "found") == 3 * address:
                return
        raise AssertionError(f"the word at {address:#x} does not come")

    async def memory(self, ctx):
        axi = self.dut.axi
        while True:
            ctx.set(axi.arready, not self.is_slow)
            _, _, valid, ready, address = await ctx.tick("edges_memory").sample(axi.arvalid, axi.arready, axi.araddr)
            if valid and ready:
                self.taken.append(address)
                ctx.set(axi.arready, 0)
                ctx.set(axi.rdata, 3 * address)
                ctx.set(axi.rvalid, 1)
                await self.until(ctx, "memory", axi.rready)
                ctx.set(axi.rvalid, 0)

    def run(self, bench):
        self.simulator.add_testbench(bench)
        self.simulator.add_testbench(self.memory, background=True)
        self.simulator.run()


@pytest.mark.parametrize("periods", PERIODS)
def test_registers_memory_and_interrupts_cross_the_clocks(monkeypatch, periods):
    machine = Machine(monkeypatch, periods)

    async def bench(ctx):
        machine.begin(ctx)
        for address in 0x1234, 0x88, 0xABCDE:
            await machine.write(ctx, "address", address)
            assert await machine.read(ctx, "address") == address
            await machine.found(ctx, address)
        assert machine.taken == [0x1234, 0x88, 0xABCDE]
        assert not ctx.get(machine.dut.irq)
        await machine.write(ctx, "interrupt", 1)
        await machine.until(ctx, "host", machine.dut.irq)
    machine.run(bench)


@pytest.mark.parametrize("periods", PERIODS)
@pytest.mark.parametrize("which", RESETS)
def test_each_reset_resets_all_sides_however_short_it_is(monkeypatch, which, periods):
    machine = Machine(monkeypatch, periods)
    host, axi = machine.dut.host, machine.dut.axi

    async def bench(ctx):
        machine.begin(ctx)
        await machine.write(ctx, "interrupt", 1)
        await machine.write(ctx, "address", 0x44)
        await machine.found(ctx, 0x44)
        await machine.until(ctx, "host", machine.dut.irq)
        machine.is_slow = True
        await machine.tick(ctx, "memory", 4)
        await machine.write(ctx, "address", 0x99)
        await machine.until(ctx, "memory", axi.arvalid)
        machine.reset(ctx, which, True)
        await ctx.delay(0.5e-9)
        for pin in host.awready, host.arready, host.wready, host.bvalid, host.rvalid, axi.arvalid, axi.rready:
            assert not ctx.get(pin)
        machine.reset(ctx, which, False)
        machine.is_slow = False
        # Even at once: what is offered waits for the end of all resets.
        assert await machine.read(ctx, "address") == 0
        assert await machine.read(ctx, "interrupt") == 0
        await machine.tick(ctx, "host", 4)
        assert not ctx.get(machine.dut.irq)
        await machine.write(ctx, "address", 0x55)
        await machine.found(ctx, 0x55)
        assert machine.taken == [0x44, 0x55]
    machine.run(bench)


@pytest.mark.parametrize("which", RESETS)
def test_all_sides_wait_for_the_last_reset(monkeypatch, which):
    machine = Machine(monkeypatch, PERIODS[0])

    async def bench(ctx):
        for name in RESETS:
            machine.reset(ctx, name, name == which)
        ctx.set(machine.dut.host.arvalid, 1)
        for _ in range(20):
            await machine.tick(ctx, "host")
            assert not ctx.get(machine.dut.host.arready)
        machine.reset(ctx, which, False)
        await machine.until(ctx, "host", machine.dut.host.arready)
    machine.run(bench)


@pytest.mark.parametrize("slow", RESETS)
def test_all_sides_stay_in_reset_until_each_clock_has_had_its_edges(monkeypatch, slow):
    """The queues between two clocks need resets that overlap."""
    machine = Machine(monkeypatch, [500 if name == slow else 10 for name in RESETS])

    async def bench(ctx):
        machine.begin(ctx)
        await machine.until(ctx, "host", machine.dut.host.arready)
        machine.reset(ctx, "host", True)
        await machine.tick(ctx, "host")
        machine.reset(ctx, "host", False)
        ctx.set(machine.dut.host.arvalid, 1)
        for _ in range(HELD - 1):
            await machine.tick(ctx, slow)
            assert not ctx.get(machine.dut.host.arready)
        await machine.until(ctx, "host", machine.dut.host.arready)
    machine.run(bench)


def test_interrupts_do_not_wait_for_the_clock_of_main_memory(monkeypatch):
    machine = Machine(monkeypatch, (10, 1000, 13))

    async def bench(ctx):
        machine.begin(ctx)
        await ctx.delay(10e-6)
        await machine.write(ctx, "interrupt", 1)
        await machine.tick(ctx, "host", 20)
        assert ctx.get(machine.dut.irq)
    machine.run(bench)
