"""A host in hardware, at a machine that only has registers."""

import dataclasses
import random
import zlib

import pytest

from golden.base.errors import InputError
from golden.engine.config import PRESETS
from golden.engine.jobs.completion import COMPLETION
from golden.engine.memory_map import MAGIC as IMAGE_MAGIC
from hw.board.frame import FrameKind, header
from hw.board.program import Operation, Program, Step
from hw.board.sequencer import Sequencer
from hw.registers.engine_registers import ENGINE_REGISTERS, MAGIC, VERSION, register
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from radiosity.flow.board.record import record
from radiosity.flow.board.view import board_view
from tb.board.decoder import Frame, frames
from tb.lib.seed import SEED
from tb.lib.simulator import simulator_of

BOARD = PRESETS["board"]
ADDRESSES = addresses(ENGINE_REGISTERS)
SENT = FrameKind.COMPLETIONS, FrameKind.DESCRIPTORS, FrameKind.HITS
ACKNOWLEDGE = (ADDRESSES["interrupt"], register("interrupt").pack(enable=1, pending=1))
MEMORY = random.Random(7).randbytes(8 * 20)
# Reads of the status while units are being reset.
RESETTING = 4
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
    """Registers and memory that are slow. A doorbell brings interrupts; the machine is busy until the last one.

    It is reset by a program's restart, and completes ``count`` descriptors then.
    """

    def __init__(self, component, *, values=(), fails=False, memory=MEMORY, interrupts=3, count=2):
        self.component, self.memory, self.random = component, memory, random.Random(SEED)
        self.values = {ADDRESSES["magic"]: MAGIC, ADDRESSES["version"]: VERSION, ADDRESSES["clusters"]: 1,
                       **dict(values)}
        self.fails, self.interrupts, self.count = fails, interrupts, count
        # Interrupts still to come, and reads of the status since the last one.
        self.coming, self.looks = 0, 0
        self.writes, self.sent = [], bytearray()
        self.simulator = simulator_of(component)
        for process in self._reads, self._writes, self._peeks, self._takes, self._interrupts:
            self.simulator.add_testbench(process, background=True)

    async def _stall(self, ctx):
        for _ in range(self.random.choice((0, 0, 1, 3))):
            await ctx.tick()

    async def _reads(self, ctx):
        host = self.component.host
        while True:
            await self._stall(ctx)
            ctx.set(host.arready, 1)
            address = await _when(ctx, host.arvalid, host.araddr)
            ctx.set(host.arready, 0)
            await self._stall(ctx)
            value = self.values.get(address, 0)
            if address == ADDRESSES["status"]:
                self.looks += 1
                assert self.looks == 1 or self.fails, "the status is read once after each interrupt"
                # Units are still being reset when a queue that halts interrupts.
                value = register("status").pack(busy=1) if self.coming else register("status").pack(
                    loaded=not self.fails, failed=self.fails, halted=self.fails,
                    busy=self.fails and self.looks < RESETTING)
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
            if found["aw"] == ADDRESSES["doorbell"]:
                self.coming = self.interrupts if found["w"] else 0
                self.values[ADDRESSES["completed"]] = self.count if found["w"] else 0
            if self.writes[-1] == ACKNOWLEDGE:
                ctx.set(self.component.irq, 0)
            await self._stall(ctx)
            ctx.set(host.bresp, 0 if found["aw"] < 0x100 else 2)
            ctx.set(host.bvalid, 1)
            await _when(ctx, host.bready)
            ctx.set(host.bvalid, 0)

    async def _interrupts(self, ctx):
        interrupt = self.component.irq
        while True:
            await ctx.tick()
            if self.coming:
                await ctx.tick().repeat(self.random.choice((1, 5, 40)))
                assert not ctx.get(interrupt), "an interrupt is acknowledged"
                self.coming, self.looks = self.coming - 1, 0
                ctx.set(interrupt, 1)
                while ctx.get(interrupt) or not self.looks:
                    await ctx.tick()

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
                    assert ctx.get(component.restarts)
                    self.values[ADDRESSES["completed"]] = 0
                    await ctx.tick()
                    ctx.set(component.again, 0)
                for _ in range(200_000):
                    *_, busy, bad, restarts = await ctx.tick().sample(
                        component.busy, component.failed, component.restarts)
                    assert not restarts
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
    program, job = record(view.job), view.job
    assert len(program.memory) == job.end
    tables = {**job.tables(), job.ring: job.descriptors.tobytes(), job.completions: bytes(64 << job.ring_bits)}
    for address, data in tables.items():
        assert program.memory[address:address + len(data)] == data
    register_names = {address: name for name, address in ADDRESSES.items()}
    wrote = [(register_names.get(step.address), step.value) for step in program.steps
             if step.operation is Operation.WRITE]
    for name, value in (("ring", job.ring), ("completions", job.completions), ("ring_bits", job.ring_bits),
                        ("read_limit", job.end), ("write_limit", job.end), ("interrupt", ACKNOWLEDGE[1])):
        assert (name, value) in wrote
    # The doorbell comes last: all descriptors at once.
    assert wrote[-1] == ("doorbell", len(job.descriptors))
    assert [value for name, value in wrote if name == "doorbell"][:-1] == [0]
    assert [step.operation for step in program.steps[:3]] == [Operation.EXPECT] * 3
    (wait,) = (k for k, step in enumerate(program.steps) if step.operation is Operation.WAIT)
    assert program.steps[wait + 1] == Step(operation=Operation.EXPECT, address=ADDRESSES["completed"], value=2)
    kinds = [step.value >> 32 & 0xFF for step in program.steps if step.operation is Operation.FRAME]
    assert kinds == [kind.value for kind in (*SENT, FrameKind.ERROR)]
    assert [k for k, step in enumerate(program.steps) if step.operation is Operation.HALT] == [
        program.error - 1, len(program.steps) - 1]


def test_a_view_larger_than_the_ray_memory_has_several_sections():
    # 5,120 rays: two sections of at most 4,096 behind the load.
    config = BOARD.replace({"icu.side_bits": 7, "icu.rays": 4096})
    job = board_view(config, scene="cornell", pixels=(80, 64), cell=0.5).job
    assert len(job.descriptors) == 3
    program = record(job)
    assert program.memory[job.ring:][:192 * 3] == job.descriptors.tobytes()
    with pytest.raises(InputError, match=r"Columns must be at most 64 \(icu.side_bits\), not 80$"):
        board_view(BOARD, scene="cornell", pixels=(80, 8), cell=0.5)


def test_all_descriptors_fit_the_ring(view):
    with pytest.raises(ValueError, match=r"^Ring must have an entry for each of 2 descriptors, not 1$"):
        record(dataclasses.replace(view.job, ring_bits=0))


def sent_by(job, memory):
    """The frames of a cast."""
    (hits,) = job.phases[0].hits
    return [Frame(kind, memory[address:address + size]) for kind, address, size in zip(
        SENT, (job.completions, job.ring, hits), (COMPLETION.dtype.itemsize << job.ring_bits, job.descriptors.nbytes,
                                                  16 * 8 * 8), strict=True)]


def test_a_program_runs_any_number_of_times(view):
    program = record(view.job)
    memory = bytearray(program.memory)
    # What the machine writes: anything.
    for frame, address in zip(sent_by(view.job, memory), (view.job.completions, view.job.ring,
                                                          *view.job.phases[0].hits), strict=True):
        memory[address:address + len(frame.payload)] = random.Random(address).randbytes(len(frame.payload))
    machine = Machine(Sequencer(config=BOARD, program=program), memory=memory)
    assert machine.run(times=2) == [False, False]
    writes = [(step.address, step.value) for step in program.steps[:program.error] if step.operation is Operation.WRITE]
    assert machine.writes == 2 * (writes + [ACKNOWLEDGE] * machine.interrupts)
    expected = sent_by(view.job, bytes(memory))
    assert frames(bytes(machine.sent)) == 2 * expected
    assert len(machine.sent) == 2 * sum(len(frame.payload) + 12 for frame in expected)


def test_an_error_is_reported(view):
    program = record(view.job)
    reported = {ADDRESSES["error"]: ErrorCode.WATCHDOG.value, ADDRESSES["error_cluster"]: 3,
                ADDRESSES["error_address"]: WHERE & 0xFFFFFFFF, ADDRESSES["error_address"] + 4: WHERE >> 32}
    error = Frame(FrameKind.ERROR, b"".join(
        word.to_bytes(4, "little") for word in (ErrorCode.WATCHDOG.value, 3, WHERE & 0xFFFFFFFF, WHERE >> 32)))
    # The machine has failed, or a descriptor has not been completed.
    for fails, count in (True, 2), (False, 1):
        machine = Machine(Sequencer(config=BOARD, program=program), memory=program.memory, fails=fails, count=count,
                          values=reported)
        assert machine.run(times=2) == [True, True]
        assert frames(bytes(machine.sent)) == 2 * [error]


@pytest.mark.parametrize(("name", "value"), [("magic", 1), ("version", 7), ("clusters", 2), ("taken", 1)])
def test_another_machine_is_refused(view, name, value):
    machine = Machine(Sequencer(config=BOARD, program=record(view.job)), values={ADDRESSES[name]: value})
    assert machine.run() == [True]
    assert [frame.kind for frame in frames(bytes(machine.sent))] == [FrameKind.ERROR]
    assert machine.writes == []


@pytest.mark.parametrize("operation", [Operation.WRITE, Operation.WORD, Operation.EXPECT, Operation.WAIT])
def test_registers_that_are_not_there(operation):
    # In the part for errors it goes on.
    steps = (Step(operation=operation, address=0x200), Step(operation=Operation.HALT),
             Step(operation=Operation.WRITE, address=0x300, value=9), Step(operation=Operation.HALT))
    machine = Machine(Sequencer(config=BOARD, program=Program(steps=steps, error=2, memory=MEMORY)))
    if operation is Operation.WAIT:
        machine.coming = 1
    assert machine.run() == [True]
    before = {Operation.WRITE: [(0x200, 0)], Operation.WAIT: [ACKNOWLEDGE]}
    assert machine.writes == [*before.get(operation, ()), (0x300, 9)]


@pytest.mark.parametrize("size", [8, 1, 7, 9, 160])
def test_bytes_of_any_length(size):
    steps = (Step(operation=Operation.FRAME, value=header(FrameKind.HITS, size)),
             Step(operation=Operation.BYTES, address=0, value=size), Step(operation=Operation.CHECK),
             Step(operation=Operation.HALT))
    machine = Machine(Sequencer(config=BOARD, program=Program(steps=steps, error=3, memory=MEMORY)))
    assert machine.run() == [False]
    head = bytes([FrameKind.HITS.value]) + size.to_bytes(3, "little")
    data = IMAGE_MAGIC.to_bytes(4, "little") + head + MEMORY[:size]
    assert bytes(machine.sent) == data + zlib.crc32(data).to_bytes(4, "little")
