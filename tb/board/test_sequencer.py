"""A host in hardware, at a machine that only has registers."""

import random
import zlib

import pytest
from amaranth.sim import Simulator

from golden.errors import InputError
from golden.memory_map import MAGIC as IMAGE_MAGIC
from hw.board.frame import FrameKind, header, region_kind
from hw.board.program import Operation, Program, Step
from hw.board.record import record
from hw.board.sequencer import Sequencer
from hw.board.view import BOARD, board_view
from hw.registers.engine_registers import ENGINE_REGISTERS, MAGIC, VERSION, register
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from tb.board.decoder import Frame, frames

ADDRESSES = addresses(ENGINE_REGISTERS)
MEMORY = random.Random(7).randbytes(8 * 20)
WHERE = 0x12_3456_789A_BCD0


@pytest.fixture(scope="module")
def view():
    return board_view(BOARD, scene="cornell", pixels=(8, 8), cell=0.5)


async def _when(ctx, condition, value=None):
    """At the edge at which the condition holds: the value."""
    while True:
        *_, holds, found = await ctx.tick().sample(condition, condition if value is None else value)
        if holds:
            return found


class Machine:
    """Registers and memory that are slow; busy for some looks at the status after each command."""

    def __init__(self, component, *, values=(), fails=None, memory=MEMORY, seed=1):
        self.component, self.memory, self.random = component, memory, random.Random(seed)
        self.values = {ADDRESSES["magic"]: MAGIC, ADDRESSES["version"]: VERSION, ADDRESSES["clusters"]: 1,
                       **dict(values)}
        self.fails, self.writes, self.sent = fails, [], bytearray()
        self.simulator = Simulator(component)
        self.simulator.add_clock(1e-8)
        for process in self._reads, self._writes, self._peeks, self._takes:
            self.simulator.add_testbench(process, background=True)

    async def _stall(self, ctx):
        for _ in range(self.random.choice((0, 0, 1, 3))):
            await ctx.tick()

    async def _reads(self, ctx):
        host, looks = self.component.host, 2
        while True:
            await self._stall(ctx)
            ctx.set(host.arready, 1)
            address = await _when(ctx, host.arvalid, host.araddr)
            ctx.set(host.arready, 0)
            await self._stall(ctx)
            value = self.values.get(address, 0)
            if address == ADDRESSES["status"]:
                looks -= 1
                value = register("status").pack(casts=1) if looks else register("status").pack(
                    loaded=1, present=1, failed=int(self.fails is not None and self.fails == len(self.writes)))
                looks = looks or 3
            ctx.set(host.rdata, value)
            ctx.set(host.rresp, 0 if address < 0x100 else 2)
            ctx.set(host.rvalid, 1)
            await _when(ctx, host.rready)
            ctx.set(host.rvalid, 0)

    async def _writes(self, ctx):
        host = self.component.host
        while True:
            # Address and data in either order.
            order = [("aw", host.awaddr), ("w", host.wdata)]
            self.random.shuffle(order)
            found = {}
            for name, value in order:
                await self._stall(ctx)
                ready, valid = getattr(host, f"{name}ready"), getattr(host, f"{name}valid")
                ctx.set(ready, 1)
                found[name] = await _when(ctx, valid, value)
                ctx.set(ready, 0)
            self.writes.append((found["aw"], found["w"]))
            await self._stall(ctx)
            ctx.set(host.bresp, 0 if found["aw"] < 0x100 else 2)
            ctx.set(host.bvalid, 1)
            await _when(ctx, host.bready)
            ctx.set(host.bvalid, 0)

    async def _peeks(self, ctx):
        component = self.component
        while True:
            await self._stall(ctx)
            ctx.set(component.o_peek.ready, 1)
            beat = await _when(ctx, component.o_peek.valid, component.o_peek.payload)
            ctx.set(component.o_peek.ready, 0)
            await self._stall(ctx)
            ctx.set(component.i_peek.payload, int.from_bytes(self.memory[8 * beat:8 * beat + 8], "little"))
            ctx.set(component.i_peek.valid, 1)
            await _when(ctx, component.i_peek.ready)
            ctx.set(component.i_peek.valid, 0)

    async def _takes(self, ctx):
        component = self.component
        while True:
            await self._stall(ctx)
            ctx.set(component.o.ready, 1)
            value = await _when(ctx, component.o.valid, component.o.payload)
            self.sent.append(value)
            ctx.set(component.o.ready, 0)

    def run(self, times=1):
        """To the end of the program, as often; whether it failed each time."""
        failed, component = [], self.component

        async def watch(ctx):
            for number in range(times):
                if number:
                    ctx.set(component.again, 1)
                    await ctx.tick()
                    ctx.set(component.again, 0)
                for _ in range(200_000):
                    *_, busy, bad = await ctx.tick().sample(component.busy, component.failed)
                    if not busy:
                        break
                else:
                    raise AssertionError("the program must come to its end")
                failed.append(bool(bad))
            await ctx.tick().repeat(10)

        self.simulator.add_testbench(watch)
        self.simulator.run()
        return failed


def test_a_recorded_program_is_what_the_driver_does(view):
    program, image = record(view.image, BOARD, total=5), view.image
    assert program.memory == image.to_bytes()
    register_names = {address: name for name, address in ADDRESSES.items()}
    wrote = [(register_names.get(step.address), step.value) for step in program.steps
             if step.operation is Operation.WRITE]
    offsets = image.offsets
    for name, value in ("image", 0), ("read_limit", len(program.memory)), ("write_base", offsets["hits"]), ("total", 5):
        assert (name, value) in wrote
    assert [value for name, value in wrote if name == "command"] == [
        register("command").pack(**{name: 1}) for name in ("load", "cast", "write", "clear")]
    assert [step.operation for step in program.steps[:3]] == [Operation.EXPECT] * 3
    kinds = [step.value >> 32 & 0xFF for step in program.steps if step.operation is Operation.FRAME]
    assert kinds == [FrameKind.CYCLES.value, *map(region_kind, ("frustum", "hits", "sums")), FrameKind.ERROR.value]
    assert [k for k, step in enumerate(program.steps) if step.operation is Operation.HALT] == [
        program.error - 1, len(program.steps) - 1]
    with pytest.raises(InputError, match="Columns must be at most"):
        record(board_view(BOARD.replace({"icu.side_bits": 7, "icu.rays": 1 << 14}), scene="cornell", pixels=(80, 8),
                          cell=0.5).image, BOARD)


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.nightly)])
def test_a_program_runs_any_number_of_times(view, seed):
    program, image = record(view.image, BOARD), view.image
    machine = Machine(Sequencer(config=BOARD, program=program), values={ADDRESSES["cycles"]: 0x12345678},
                      memory=program.memory, seed=seed)
    assert machine.run(times=2) == [False, False]
    writes = [(step.address, step.value) for step in program.steps[:program.error] if step.operation is Operation.WRITE]
    assert machine.writes == 2 * writes
    expected = [Frame(FrameKind.CYCLES.value, (0x12345678).to_bytes(4, "little")),
                *(Frame(region_kind(name), image[name].tobytes()) for name in ("frustum", "hits", "sums"))]
    assert frames(bytes(machine.sent)) == 2 * expected
    assert len(machine.sent) == 2 * sum(len(frame.payload) + 12 for frame in expected)


def test_an_error_is_reported_and_cleared(view):
    program = record(view.image, BOARD)
    reported = {ADDRESSES["error"]: ErrorCode.WATCHDOG.value, ADDRESSES["error_cluster"]: 3,
                ADDRESSES["error_address"]: WHERE & 0xFFFFFFFF, ADDRESSES["error_address"] + 4: WHERE >> 32}
    usual = [step for step in program.steps[:program.error] if step.operation is Operation.WRITE]
    # After the command to load, and after that to cast.
    commands = [k for k, step in enumerate(usual, 1) if step.address == ADDRESSES["command"]]
    for at in commands[:2]:
        machine = Machine(Sequencer(config=BOARD, program=program), values=reported, fails=at, memory=program.memory)
        assert machine.run(times=2) == [True, False]
        first, *others = frames(bytes(machine.sent))
        assert first == Frame(FrameKind.ERROR.value, b"".join(
            word.to_bytes(4, "little") for word in (ErrorCode.WATCHDOG.value, 3, WHERE & 0xFFFFFFFF, WHERE >> 32)))
        assert machine.writes[at] == (ADDRESSES["command"], register("command").pack(clear=1))
        assert [frame.kind for frame in others] == [FrameKind.CYCLES.value, *map(
            region_kind, ("frustum", "hits", "sums"))]


@pytest.mark.parametrize(("name", "value"), [("magic", 1), ("version", 7), ("clusters", 2)])
def test_another_machine_is_refused(view, name, value):
    machine = Machine(Sequencer(config=BOARD, program=record(view.image, BOARD)), values={ADDRESSES[name]: value})
    assert machine.run() == [True]
    assert [frame.kind for frame in frames(bytes(machine.sent))] == [FrameKind.ERROR.value]
    assert machine.writes == [(ADDRESSES["command"], register("command").pack(clear=1))]


@pytest.mark.parametrize("operation", [Operation.WRITE, Operation.WORD, Operation.EXPECT, Operation.WAIT])
def test_registers_that_are_not_there(operation):
    # In the part for errors it goes on.
    steps = (Step(operation=operation, address=0x200), Step(operation=Operation.HALT),
             Step(operation=Operation.WRITE, address=0x300, value=9), Step(operation=Operation.HALT))
    machine = Machine(Sequencer(config=BOARD, program=Program(steps=steps, error=2, memory=MEMORY)))
    assert machine.run() == [True]
    assert machine.writes == [(0x200, 0)] * (operation is Operation.WRITE) + [(0x300, 9)]


@pytest.mark.parametrize("size", [8, 1, 7, 9, 160])
def test_bytes_of_any_length(size):
    steps = (Step(operation=Operation.FRAME, value=header(5, size)),
             Step(operation=Operation.BYTES, address=0, value=size), Step(operation=Operation.CHECK),
             Step(operation=Operation.HALT))
    machine = Machine(Sequencer(config=BOARD, program=Program(steps=steps, error=3, memory=MEMORY)))
    assert machine.run() == [False]
    data = IMAGE_MAGIC.to_bytes(4, "little") + bytes([5]) + size.to_bytes(3, "little") + MEMORY[:size]
    assert bytes(machine.sent) == data + zlib.crc32(data).to_bytes(4, "little")
