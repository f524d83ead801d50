"""Registers at a manager that others wrote: cocotbext-axi's."""

import random

import cocotb
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from hw.registers.register import WORD_BYTES, Access, Field, Register, addresses, register_table
from hw.registers.registers import OKAY, Registers
from tb.axi.axi_lite_protocol import AxiLiteProtocol
from tb.axi.port_monitor import PortMonitor
from tb.lib.clocking import reset, start
from tb.lib.no_x import assert_known
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor
from tb.registers.register_model import RegisterModel

MODULE = "tb.registers.test_registers"
ADDRESS_BITS = 8
WINDOW = 1 << ADDRESS_BITS - 1
TABLE = (
    Register(name="wide", access=Access.READ, width=50, about="A long number of the machine's."),
    Register(name="said", access=Access.READ, about="A number of the machine's."),
    Register(name="mode", access=Access.WRITE, width=5, about="Of the host's.", reset=9,
             fields=(Field(name="low", width=2, about="bits"), Field(name="high", width=3, about="more bits"))),
    Register(name="base", access=Access.WRITE, width=44, about="A long one.", reset=7 << 35),
    Register(name="go", access=Access.COMMAND, width=12, about="A command."))
ADDRESSES = addresses(TABLE)


class Bench:
    """A manager, and a window that answers when it likes."""

    def __init__(self, dut, *, seed=0):
        from cocotbext.axi import AxiLiteBus, AxiLiteMaster

        self.dut, self.random = dut, random.Random(seed)
        self.master = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "host", bus_separator="__"), dut.clk, dut.rst)
        self.master.write_if.log.setLevel("WARNING")
        self.master.read_if.log.setLevel("WARNING")
        PortMonitor(dut, "host", AxiLiteProtocol(ADDRESS_BITS))
        self.commands = Monitor(dut, "go")
        self._task = None
        self.answer()

    def answer(self):
        """Begin to answer for the window."""
        if self._task is not None:
            self._task.cancel()
        self.dut.i_window__valid.value = self.dut.o_window__ready.value = 0
        self._task = cocotb.start_soon(self._window())

    async def _window(self):
        dut, edge = self.dut, RisingEdge(self.dut.clk)
        while True:
            dut.o_window__ready.value = 1
            await edge
            while not int(dut.o_window__valid.value):
                await edge
            index = int(dut.o_window__payload.value)
            dut.o_window__ready.value = 0
            await ClockCycles(dut.clk, self.random.randrange(1, 6))
            dut.i_window__valid.value, dut.i_window__payload.value = 1, index * 1001
            await edge
            while not int(dut.i_window__ready.value):
                await edge
            dut.i_window__valid.value = 0

    def stall(self, host, machine, seed):
        """Who waits: what the manager gives, and what it takes."""
        write, read = self.master.write_if, self.master.read_if
        for k, channel in enumerate((write.aw_channel, write.w_channel, read.ar_channel)):
            channel.set_pause_generator(STALLS[host](seed + k))
        for k, channel in enumerate((write.b_channel, read.r_channel)):
            channel.set_pause_generator(STALLS[machine](seed + 7 + k))

    async def read(self, address):
        reply = await self.master.read(address, 4)
        return int.from_bytes(reply.data, "little"), int(reply.resp)

    async def write(self, address, value, size=4):
        return int((await self.master.write(address, value.to_bytes(size, "little"))).resp)


async def exercise(bench, count):
    """Reads and writes at random after a reset, compared with what the table says."""
    dut, draw = bench.dut, bench.random
    bench.commands.items.clear()
    model, commands = RegisterModel(TABLE), []
    said = {"said": draw.getrandbits(32), "wide": draw.getrandbits(50)}
    for name, value in said.items():
        getattr(dut, name).value = value
    known = [WORD_BYTES * word for word in model.words]
    for _ in range(count):
        address = draw.choice([*known, *known, 100, WINDOW - 4, WINDOW, WINDOW + 76])
        if draw.random() < 0.5:
            value, resp = await bench.read(address)
            expected = model.read(address, said) if address < WINDOW else {
                "data": (address - WINDOW) // 4 * 1001, "resp": OKAY}
            assert {"data": value, "resp": resp} == expected, f"a read at {address:#x}"
            continue
        # Some bytes of a word only, now and then.
        skip, size = draw.choice([(0, 4), (0, 4), (1, 2), (3, 1)])
        value = draw.getrandbits(draw.choice([8 * size, 5]))
        resp = await bench.write(address + skip, value, size)
        expected, command = model.write(address, value << 8 * skip, (1 << size) - 1 << skip)
        assert resp == expected, f"a write at {address:#x}"
        commands += [command[1]] if command else []
    await RisingEdge(dut.clk)
    for name, value in model.held.items():
        assert int(getattr(dut, name).value) == value
    assert bench.commands.items == commands


@cocotb.test()
async def everything_at_random(dut):
    """Registers, addresses without one, bytes of words, the window; every pair of stall patterns."""
    dut.said.value = dut.wide.value = 0
    await start(dut, cycles=60_000)
    bench = Bench(dut, seed=options()["seed"])
    for number, (host, machine) in enumerate(STALL_PAIRS):
        await reset(dut)
        await RisingEdge(dut.clk)
        assert_known(dut, ["o_window"])
        bench.stall(host, machine, number)
        await exercise(bench, 25)


@cocotb.test()
async def reset_in_flight(dut):
    """What was in flight is gone, and registers hold what they did at first."""
    dut.said.value = dut.wide.value = 0
    await start(dut, cycles=20_000)
    bench = Bench(dut, seed=options()["seed"])
    await reset(dut)
    for cycles in range(1, 14, 2):
        tasks = [cocotb.start_soon(bench.write(ADDRESSES["mode"], 3)), cocotb.start_soon(bench.read(WINDOW))]
        await ClockCycles(dut.clk, cycles)
        for task in tasks:
            task.cancel()
        bench.answer()
        await reset(dut)
        assert await bench.read(ADDRESSES["mode"]) == (9, OKAY)
        assert await bench.read(ADDRESSES["base"] + 4) == (7 << 3, OKAY)
        await exercise(bench, 5)
        await reset(dut)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_registers(simulator):
    simulate(Registers(TABLE, address_bits=ADDRESS_BITS), MODULE,
             ("everything_at_random", "reset_in_flight"), simulator=simulator, name=f"registers-{simulator}")


def test_what_cannot_be():
    with pytest.raises(ValueError, match="Registers must end at 16, not 28"):
        Registers(TABLE, address_bits=5)
    with pytest.raises(ValueError, match="Names of registers must differ, not be said twice"):
        addresses((TABLE[1], TABLE[1]))
    with pytest.raises(ValueError, match="Address of wide must be a multiple of its bytes, not 0x4"):
        addresses((TABLE[1], TABLE[0]))
    with pytest.raises(ValueError, match="Access of a must be WRITE, as it has a rule, not READ"):
        Register(name="a", access=Access.READ, about="", most=3)
    with pytest.raises(ValueError, match="Width must be from 1 to 64, not 65"):
        Register(name="a", access=Access.READ, about="", width=65)
    with pytest.raises(ValueError, match="Width of a command must be at most 32, not 33"):
        Register(name="a", access=Access.COMMAND, about="", width=33)
    with pytest.raises(ValueError, match="Fields of a must have at most 3 bits, not 4"):
        Register(name="a", access=Access.READ, about="", width=3, fields=(Field(name="b", width=4, about=""),))
    with pytest.raises(ValueError, match=r"mode\.low must be from 0 to 3, not 4"):
        TABLE[2].pack(low=4)
    with pytest.raises(KeyError, match="there is no middle in mode"):
        TABLE[2].pack(middle=1)


@pytest.mark.parametrize(("low", "high"), [(0, 0), (3, 0), (1, 5), (3, 7)])
def test_fields_are_packed_and_unpacked(low, high):
    value = TABLE[2].pack(low=low, high=high)
    assert value == low | high << 2
    assert TABLE[2].unpack(value) == {"low": low, "high": high}


def test_a_table_has_every_register_and_field():
    text = register_table(TABLE)
    for one in TABLE:
        assert f"| {ADDRESSES[one.name]:#05x} | `{one.name}` |" in text
    assert "| | `.high` | 4:2 |" in text
