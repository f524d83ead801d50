# amaranth: UnusedElaboratable=no
"""What the engine obeys, what it refuses, and how what goes wrong ends."""

import random

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.control.engine_control import EngineControl
from hw.control.load_control import ALL
from hw.memsys.fault import Fault
from hw.memsys.path_fault import PathFault
from hw.noc.network_fault import NetworkFault
from hw.registers.engine_registers import register
from hw.registers.error_code import LIST, NETWORK, PATH, ErrorCode

CONFIG = PRESETS["tiny"]


class Around:
    """The engine's units, which take some cycles each."""

    def __init__(self, ctx, dut, *, seed=1):
        self.ctx, self.dut, self._random = ctx, dut, random.Random(seed)
        self.left = dict.fromkeys(("loads", "casts", "writes"), 0)
        self.begun, self.took = [], 10
        self.over = {"loads": Fault.NONE, "writes": Fault.NONE}
        ctx.set(dut.watchdog, 1000)
        ctx.set(dut.regions, ALL)

    async def step(self, command=None):
        """One cycle."""
        ctx, dut = self.ctx, self.dut
        ctx.set(dut.i_command.valid, command is not None)
        ctx.set(dut.i_command.payload, register("command").pack(**{command: 1}) if command else 0)
        stops = ctx.get(dut.stops)
        for name, begins in (("loads", dut.loading), ("casts", dut.casting), ("writes", dut.writing)):
            ctx.set(getattr(dut, name), self.left[name] > 0)
            over = getattr(dut, f"{name[:-1]}_over", None)
            if over is not None:
                ctx.set(over.valid, self.left[name] == 1 and not stops)
                ctx.set(over.payload.code, self.over[name])
            if self.left[name]:
                self.left[name] -= 1
            if stops:
                self.left[name] = 0
            if ctx.get(begins):
                assert not stops
                self.begun.append(name)
                self.left[name] = self.took
        await ctx.tick()

    async def command(self, name, *, steps=1):
        """A command, and whether it has begun something."""
        before = len(self.begun)
        await self.step(name)
        for _ in range(1 + steps):
            await self.step()
        return self.begun[before:]

    async def finish(self):
        """Until nothing is in flight."""
        while any(self.left.values()) or self.status["stops"]:
            await self.step()
        await self.step()

    @property
    def status(self):
        """The register."""
        return register("status").unpack(self.ctx.get(self.dut.status))

    @property
    def error(self):
        """Code, cluster, number."""
        error = self.dut.error
        return (ErrorCode(self.ctx.get(error.code)), self.ctx.get(error.cluster), self.ctx.get(error.number))

    async def clear(self):
        """Forget the error."""
        await self.step("clear")
        await self.step()
        assert self.error == (ErrorCode.NONE, 0, 0)


def run(bench):
    dut = EngineControl(config=CONFIG)

    async def testbench(ctx):
        await bench(Around(ctx, dut))

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(testbench)
    simulator.run()


def test_commands_in_their_order():
    async def bench(around):
        assert await around.command("cast") == []
        assert around.error[0] is ErrorCode.NOT_LOADED
        await around.clear()
        assert await around.command("write") == []
        assert around.error[0] is ErrorCode.COMMAND
        await around.clear()
        assert await around.command("load") == ["loads"]
        for refused in ("load", "cast", "write"):
            assert await around.command(refused, steps=0) == []
            assert around.error[0] is ErrorCode.COMMAND
            await around.clear()
        await around.finish()
        assert around.status["loaded"]
        assert await around.command("cast") == ["casts"]
        assert around.status["casts"]
        assert around.status["present"]
        assert not around.status["earlier"]
        for refused in ("load", "cast", "write"):
            assert await around.command(refused, steps=0) == []
        await around.finish()
        await around.clear()
        assert await around.command("write") == ["writes"]
        await around.finish()
        # Results of the frustum before may be written during the next one, and only these.
        assert await around.command("cast", steps=0) == ["casts"]
        around.ctx.set(around.dut.earlier, 1)
        assert await around.command("write") == ["writes"]
        assert around.error[0] is ErrorCode.NONE
        await around.finish()
        assert around.status["earlier"]

    run(bench)


def test_a_part_is_not_all_and_a_fault_is_no_load():
    async def bench(around):
        around.ctx.set(around.dut.regions, ALL & ~2)
        await around.command("load")
        await around.finish()
        assert not around.status["loaded"]
        around.ctx.set(around.dut.regions, ALL)
        await around.command("load")
        await around.finish()
        assert around.status["loaded"]
        around.ctx.set(around.dut.regions, 2)
        await around.command("load")
        await around.finish()
        assert around.status["loaded"], "a part more"
        around.over["loads"] = Fault.POINTER
        await around.command("load")
        await around.finish()
        assert not around.status["loaded"]
        assert around.error[0] is ErrorCode.POINTER
        await around.clear()
        around.over["loads"] = Fault.NONE
        await around.command("load")
        await around.finish()
        assert not around.status["loaded"], "what is in disorder is not mended by a part"

    run(bench)


@pytest.mark.parametrize(("code", "cluster", "stops"), [
    (PATH + PathFault.BUS.value, 1, False), (PATH + PathFault.TIMEOUT.value, 0, True), (LIST + 1, 1, False),
    (ErrorCode.SECTION.value, 0, False)])
def test_faults_of_clusters(code, cluster, stops):
    async def bench(around):
        ctx, dut = around.ctx, around.dut
        await around.command("load")
        await around.finish()
        around.took = 60
        await around.command("cast")
        ctx.set(dut.memory_busy, 1)
        ctx.set(dut.clusters[cluster].code, code)
        ctx.set(dut.clusters[cluster].number, 1234)
        for _ in range(4):
            await around.step()
        assert around.error == (ErrorCode(code), cluster, 1234)
        assert around.status["stops"] == stops
        # The unit forgets when it is told to.
        if stops:
            assert ctx.get(dut.clear)
            ctx.set(dut.clusters[cluster].code, 0)
            ctx.set(dut.memory_busy, 0)
            await around.finish()
            assert not around.status["loaded"]
        else:
            await around.step("clear")
            ctx.set(dut.clusters[cluster].code, 0)
            for _ in range(4):
                await around.step()
            assert around.error[0] is ErrorCode.NONE, "what has been forgotten does not come back"

    run(bench)


def test_a_network_fault_stops():
    async def bench(around):
        around.ctx.set(around.dut.memory_busy, 1)
        around.ctx.set(around.dut.networks[1], NetworkFault.ORDER)
        for _ in range(4):
            await around.step()
        assert around.error[:2] == (ErrorCode(NETWORK + NetworkFault.ORDER.value), 1)
        assert around.status["stops"]

    run(bench)


def test_the_watchdog_stops_when_no_memory_reply_is_outstanding():
    async def bench(around):
        ctx, dut = around.ctx, around.dut
        ctx.set(dut.watchdog, 50)
        await around.command("load")
        await around.finish()
        assert around.status["loaded"]
        around.took = 10_000
        await around.command("cast")
        waited = 0
        ctx.set(dut.memory_busy, 1)
        while not around.status["stops"]:
            await around.step()
            waited += 1
        assert 40 < waited < 60
        assert around.error[0] is ErrorCode.WATCHDOG
        for _ in range(200):
            await around.step()
            assert around.status["stops"]
        assert await around.command("load") == []
        ctx.set(dut.memory_busy, 0)
        await around.step()
        assert not around.status["stops"], "memory is the only thing that a stop waits for"
        assert not around.status["loaded"]
        around.took = 5
        await around.clear()
        assert await around.command("load") == ["loads"]
        await around.finish()
        assert around.status["loaded"]

    run(bench)


def test_the_host_can_stop():
    async def bench(around):
        await around.command("load")
        around.ctx.set(around.dut.memory_busy, 1)
        await around.command("stop")
        assert around.status["stops"]
        around.ctx.set(around.dut.memory_busy, 0)
        await around.finish()
        assert not around.status["loads"]
        assert around.error[0] is ErrorCode.NONE

    run(bench)


def test_a_watchdog_of_0_is_off():
    async def bench(around):
        around.ctx.set(around.dut.watchdog, 0)
        assert await around.command("load") == ["loads"]
        await around.finish()
        assert around.status["loaded"]
        around.took = 500
        assert await around.command("cast") == ["casts"]
        await around.finish()
        assert around.error[0] is ErrorCode.NONE

    run(bench)


@pytest.mark.parametrize("second", ["load", "cast", "write"])
def test_a_command_in_the_cycle_in_which_another_begins_is_refused(second):
    async def bench(around):
        await around.command("load")
        await around.finish()
        await around.command("cast")
        await around.finish()
        before = len(around.begun)
        await around.step("load")
        await around.step(second)
        for _ in range(3):
            await around.step()
        assert around.begun[before:] == ["loads"]
        assert around.error[0] is ErrorCode.COMMAND

    run(bench)


def test_the_watchdog_does_not_count_while_nothing_is_in_flight():
    async def bench(around):
        around.ctx.set(around.dut.watchdog, 50)
        await around.command("load")
        await around.finish()
        for _ in range(200):
            await around.step()
        assert await around.command("cast") == ["casts"]
        await around.finish()
        assert around.error[0] is ErrorCode.NONE
        assert around.status["loaded"]

    run(bench)
