"""The engine's three clocks: a small unit stands for the engine between its crossings."""

import random
from itertools import count

import pytest
from amaranth.hdl import ClockDomain, Module, Signal
from amaranth.lib import wiring

import hw.async_engine
from hw.async_engine import HELD, AsyncEngine
from hw.lib.clock_crossing import ClockCrossing
from hw.registers.engine_registers import ADDRESS_BITS
from hw.registers.register import addresses
from tb.axi.axi_lite_protocol import AxiLiteProtocol
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.protocol_monitor import ProtocolError, ProtocolMonitor
from tb.lib.seed import SEED
from tb.lib.simulator import simulator_of
from tb.system.copier import CONFIG, TABLE, WORD, Copier

PLACES = addresses(TABLE)
# Nanoseconds of a cycle of the engine, main memory and the host.
PERIODS = [(10, 7, 13), (5, 17, 3), (10, 10, 10)]
RESETS = ("engine", "memory", "host")
WATCHDOG = 500


class Withdrawing(wiring.Component):
    """A `ClockCrossing` that withdraws its offer in every second cycle: a negative control."""

    def __init__(self, shape, *, source, sink):
        self._crossing, self._sink = ClockCrossing(shape, source=source, sink=sink), sink
        super().__init__(self._crossing.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.crossing = crossing = self._crossing
        offers = Signal()
        m.d[self._sink] += offers.eq(~offers)
        wiring.connect(m, wiring.flipped(self.i), crossing.i)
        m.d.comb += [self.o.payload.eq(crossing.o.payload), self.o.valid.eq(crossing.o.valid & offers),
                     crossing.o.ready.eq(self.o.ready & offers)]
        return m


class Machine:
    """An `AsyncEngine` around a `Copier`, a host, and a main memory that answers three times the address.

    Host and memory stall at random. A violation of AXI's rules at either port fails the test.

    Members
    -------
    is_slow
        Main memory takes no addresses.
    taken, written
        Addresses that it has taken, and addresses and words of writes.
    monitors
        Of the ports, by the clock. The host offers accesses in resets too: of its port they check the engine alone.
    """

    def __init__(self, monkeypatch, periods):
        monkeypatch.setattr(hw.async_engine, "Engine", Copier)
        self.dut, self.is_slow, self.taken, self.written = AsyncEngine(config=CONFIG), False, [], []
        self.edges = {name: ClockDomain(f"edges_{name}", reset_less=True) for name in RESETS}
        self.sync = ClockDomain("sync")
        m = Module()
        m.submodules.dut = self.dut
        m.domains += [self.sync, *self.edges.values()]
        clocks = {"engine": self.sync.clk, "memory": self.dut.m_axi_aclk, "host": self.dut.s_axil_aclk}
        for name, domain in self.edges.items():
            m.d.comb += clocks[name].eq(domain.clk)
        self.simulator = simulator_of(m, period=None)
        self.draw = random.Random(SEED)
        for domain, period in zip(self.edges.values(), periods, strict=True):
            self.simulator.add_clock(period * 1e-9, phase=self.draw.random() * period * 1e-9, domain=domain.name)
        self.ports, lite = {"memory": self.dut.axi, "host": self.dut.host}, AxiLiteProtocol(ADDRESS_BITS)
        self.monitors = {"memory": ProtocolMonitor(AxiProtocol(CONFIG)),
                         "host": ProtocolMonitor(lite, lite.subordinate)}
        # Resets that are on, and the ports that have not had an edge since one was.
        self.active, self.withdrawn = {"memory", "host"}, set()

    async def tick(self, ctx, name, cycles=1):
        for _ in range(cycles):
            await ctx.tick(f"edges_{name}")

    def reset(self, ctx, name, is_on):
        """Drive one of the resets."""
        signal, active = {"engine": (self.sync.rst, 1), "memory": (self.dut.m_axi_aresetn, 0),
                          "host": (self.dut.s_axil_aresetn, 0)}[name]
        ctx.set(signal, active if is_on else 1 - active)
        if is_on:
            self.active.add(name)
            self.withdrawn.update(self.ports)
        else:
            self.active.discard(name)

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

    async def give(self, ctx, name, channel, **pins):
        """Offer an item of a channel until it is accepted."""
        port = self.ports[name]
        for pin, value in pins.items():
            ctx.set(getattr(port, pin), value)
        ctx.set(getattr(port, f"{channel}valid"), 1)
        await self.until(ctx, name, getattr(port, f"{channel}ready"))
        ctx.set(getattr(port, f"{channel}valid"), 0)

    async def take(self, ctx, name, channel, *pins, cycles):
        """Accept an item of a channel: its pins."""
        port = self.ports[name]
        valid, ready, *values = (getattr(port, pin) for pin in (f"{channel}valid", f"{channel}ready", *pins))
        for _ in cycles:
            is_ready = self.draw.random() < 0.5 and not (name == "memory" and self.is_slow)
            ctx.set(ready, is_ready)
            _, _, comes, *came = await ctx.tick(f"edges_{name}").sample(valid, *values)
            if comes and is_ready:
                ctx.set(ready, 0)
                return came
        raise AssertionError(f"{valid.name} stays 0")

    async def write(self, ctx, name, value):
        await self.give(ctx, "host", "aw", awaddr=PLACES[name])
        await self.give(ctx, "host", "w", wdata=value, wstrb=15)
        await self.take(ctx, "host", "b", cycles=range(WATCHDOG))

    async def read(self, ctx, name):
        await self.give(ctx, "host", "ar", araddr=PLACES[name])
        (data,) = await self.take(ctx, "host", "r", "rdata", cycles=range(WATCHDOG))
        return data

    async def copied(self, ctx, address):
        """The engine has copied the word at an address."""
        for _ in range(WATCHDOG):
            if await self.read(ctx, "copied") == 3 * address:
                assert self.written[-1] == (address + WORD, 3 * address)
                return
        raise AssertionError(f"the word at {address:#x} does not come")

    async def memory(self, ctx):
        while True:
            (address,) = await self.take(ctx, "memory", "ar", "araddr", cycles=count())
            self.taken.append(address)
            await self.give(ctx, "memory", "r", rdata=3 * address, rlast=1)
            (address,) = await self.take(ctx, "memory", "aw", "awaddr", cycles=count())
            (data,) = await self.take(ctx, "memory", "w", "wdata", cycles=count())
            self.written.append((address, data))
            await self.give(ctx, "memory", "b")

    def watch(self, name):
        """A process that checks every cycle of a port."""
        monitor, port = self.monitors[name], self.ports[name]
        pins = {pin: getattr(port, pin) for pin in port.signature.members}

        async def check(ctx):
            while True:
                _, _, *values = await ctx.tick(f"edges_{name}").sample(*pins.values())
                monitor.step(dict(zip(pins, values, strict=True)), reset=bool(self.active) or name in self.withdrawn)
                self.withdrawn.discard(name)
        return check

    def run(self, bench):
        self.simulator.add_testbench(bench)
        self.simulator.add_testbench(self.memory, background=True)
        for name in self.ports:
            self.simulator.add_testbench(self.watch(name), background=True)
        self.simulator.run()


@pytest.mark.parametrize("periods", [
    PERIODS[0], *(pytest.param(periods, marks=pytest.mark.sim) for periods in PERIODS[1:])])
def test_registers_memory_and_interrupts_cross_the_clocks(monkeypatch, periods):
    machine = Machine(monkeypatch, periods)

    async def bench(ctx):
        machine.begin(ctx)
        for address in 0x1230, 0x88, 0xABCD8:
            await machine.write(ctx, "address", address)
            assert await machine.read(ctx, "address") == address
            await machine.copied(ctx, address)
        assert machine.taken == [0x1230, 0x88, 0xABCD8]
        assert not ctx.get(machine.dut.irq)
        await machine.write(ctx, "interrupt", 1)
        await machine.until(ctx, "host", machine.dut.irq)
    machine.run(bench)
    assert all(monitor.cycles for monitor in machine.monitors.values())


@pytest.mark.parametrize(("port", "rules"), [("memory", "(ar|aw|w)_stable"), ("host", "(b|r)_stable")])
def test_an_offer_withdrawn_at_a_port_fails_by_its_rule(monkeypatch, port, rules):
    monkeypatch.setattr("hw.lib.axi_crossing.ClockCrossing", lambda shape, **more: (
        Withdrawing if more["sink"] == port else ClockCrossing)(shape, **more))
    machine = Machine(monkeypatch, PERIODS[0])

    async def bench(ctx):
        machine.begin(ctx)
        for k in range(1, 50):
            await machine.write(ctx, "address", k * 2 * WORD)
            await machine.copied(ctx, k * 2 * WORD)
    with pytest.raises(ProtocolError, match=rules):
        machine.run(bench)


@pytest.mark.parametrize("periods", [
    PERIODS[0], *(pytest.param(periods, marks=pytest.mark.sim) for periods in PERIODS[1:])])
@pytest.mark.parametrize("which", RESETS)
def test_each_reset_resets_all_sides_however_short_it_is(monkeypatch, which, periods):
    machine = Machine(monkeypatch, periods)
    host, axi = machine.dut.host, machine.dut.axi

    async def bench(ctx):
        machine.begin(ctx)
        await machine.write(ctx, "interrupt", 1)
        await machine.write(ctx, "address", 0x48)
        await machine.copied(ctx, 0x48)
        await machine.until(ctx, "host", machine.dut.irq)
        machine.is_slow = True
        await machine.tick(ctx, "memory", 4)
        await machine.write(ctx, "address", 0x98)
        await machine.until(ctx, "memory", axi.arvalid)
        machine.reset(ctx, which, True)
        await ctx.delay(0.5e-9)
        for pin in (host.awready, host.arready, host.wready, host.bvalid, host.rvalid, axi.arvalid, axi.awvalid,
                    axi.wvalid, axi.rready, axi.bready):
            assert not ctx.get(pin)
        machine.reset(ctx, which, False)
        machine.is_slow = False
        # Even at once: what is offered waits for the end of all resets.
        assert await machine.read(ctx, "address") == 0
        assert await machine.read(ctx, "interrupt") == 0
        await machine.tick(ctx, "host", 4)
        assert not ctx.get(machine.dut.irq)
        await machine.write(ctx, "address", 0x50)
        await machine.copied(ctx, 0x50)
        assert machine.taken == [0x48, 0x50]
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
