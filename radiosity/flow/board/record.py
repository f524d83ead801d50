"""A program from the host's driver: its accesses are recorded instead of made."""

import asyncio

from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.jobs.job import Job
from hw.board.frame import FrameKind, header
from hw.board.program import Operation, Program, Step
from hw.registers.engine_registers import ENGINE_REGISTERS, MAGIC, VERSION, register
from hw.registers.register import WORD_BYTES, addresses
from radiosity.flow.host import Host, Port

__all__ = ["record"]

_ADDRESSES = addresses(ENGINE_REGISTERS)
_ERROR = ("error", "error_cluster", "error_address")


class _Recorder(Port):
    """A port without a machine, which records all accesses.

    Parameters
    ----------
    job
        The job, the first one since the machine was reset.
    sent
        By address in memory: the kind of frame of what is read there.
    """

    def __init__(self, job: Job, sent: dict[int, FrameKind]):
        self.steps, self.memory = [], bytearray(job.end)
        self._sent, self._waits = sent, False
        self._known = {_ADDRESSES[name]: value for name, value in (
            ("magic", MAGIC), ("version", VERSION), ("clusters", job.config.noc.clusters), ("taken", 0),
            ("completed", 0))}

    def _add(self, operation, **given):
        self.steps.append(Step(operation=operation, **given))

    async def read(self, address: int) -> int:
        """A register: its value is expected if it is known, otherwise sent."""
        if self._waits and address in (_ADDRESSES["completed"], _ADDRESSES["status"]):
            self._add(Operation.WAIT, address=_ADDRESSES["status"])
            self._waits = False
        if address == _ADDRESSES["status"]:
            return register("status").pack(loaded=1)
        if address in self._known:
            self._add(Operation.EXPECT, address=address, value=self._known[address])
            return self._known[address]
        self._add(Operation.WORD, address=address)
        return 0

    async def write(self, address: int, value: int) -> None:
        """Write a register."""
        self._add(Operation.WRITE, address=address, value=value)
        if address == _ADDRESSES["doorbell"]:
            # Before a read of the machine's state all that has been submitted is completed.
            self._known[_ADDRESSES["completed"]], self._waits = value, value > 0

    async def read_memory(self, address: int, size: int) -> bytes:
        """Send what is there."""
        self._add(Operation.FRAME, value=header(self._sent[address], size))
        self._add(Operation.BYTES, address=address, value=size)
        self._add(Operation.CHECK)
        return bytes(size)

    async def write_memory(self, address: int, data: bytes) -> None:
        """The initial contents of memory: all descriptors are submitted at once."""
        self.memory[address:address + len(data)] = data

    async def wait(self, cycles: int) -> None:
        """The recorded machine is idle."""


def record(job: Job) -> Program:
    """The accesses of `radiosity.flow.host.Host` that cast the one frustum of a job, or report an error of the machine.

    Descriptors, completion records and hits are sent, or code, cluster and address of an error.

    Raises
    ------
    ValueError
        The ring is too small for all descriptors.
    """
    count, entries = len(job.descriptors), 1 << job.ring_bits
    if count > entries:
        raise ValueError(f"Ring must have an entry for each of {count} descriptors, not {entries}")
    (phase,) = job.phases
    (hits,) = phase.hits
    usual = _Recorder(job, {job.ring: FrameKind.DESCRIPTORS, job.completions: FrameKind.COMPLETIONS,
                            hits: FrameKind.HITS})
    failed = _Recorder(job, {})

    async def cast():
        host = Host(usual, job.config)
        await host.identify()
        await host.begin(job)
        await host.write("interrupt", register("interrupt").pack(enable=1, pending=1))
        await host.run(job)
        await usual.read_memory(job.ring, DESCRIPTOR.dtype.itemsize * len(job.descriptors))
        await usual.read_memory(hits, phase.request.hit_format.bytes * len(phase.request.records[0]))

    async def tell():
        host = Host(failed, job.config)
        for name in _ERROR:
            await host.read(name)

    asyncio.run(cast())
    asyncio.run(tell())
    steps = [*usual.steps, Step(operation=Operation.HALT)]
    return Program(steps=(
        *steps, Step(operation=Operation.FRAME, value=header(FrameKind.ERROR, WORD_BYTES * len(failed.steps))),
        *failed.steps, Step(operation=Operation.CHECK), Step(operation=Operation.HALT)),
        error=len(steps), memory=bytes(usual.memory))
