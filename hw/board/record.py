"""A program from the host's driver: its accesses are recorded instead of made."""

import asyncio
from itertools import groupby

from golden.config import Config
from golden.memory_map import MemoryImage
from hw.board.frame import FrameKind, header, region_kind
from hw.board.program import Operation, Program, Step
from hw.host import EngineError, Host, Port
from hw.registers.engine_registers import ENGINE_REGISTERS, MAGIC, VERSION, register
from hw.registers.register import WORD_BYTES, addresses

__all__ = ["record"]

_ADDRESSES = addresses(ENGINE_REGISTERS)
_SENT = ("frustum", "hits", "sums")


class _Recorder(Port):
    """A port without a machine, which records all accesses.

    Parameters
    ----------
    config
        The configuration.
    regions
        By address in memory: the region there that may be sent.
    fails
        The machine's ``status`` has ``failed``.
    """

    def __init__(self, config: Config, *, regions: dict[int, str] | None = None, fails: bool = False):
        self.steps, self.memory = [], b""
        self._regions, self._fails = regions or {}, fails
        self._known = {_ADDRESSES[name]: value for name, value in (
            ("magic", MAGIC), ("version", VERSION), ("clusters", config.noc.nodes))}

    def _add(self, operation, **given):
        self.steps.append(Step(operation=operation, **given))

    async def read(self, address: int) -> int:
        """A register: its value is expected if it is known, otherwise sent."""
        if address == _ADDRESSES["status"]:
            self._add(Operation.WAIT, address=address)
            return register("status").pack(failed=int(self._fails))
        if address in self._known:
            self._add(Operation.EXPECT, address=address, value=self._known[address])
            return self._known[address]
        self._add(Operation.WORD, address=address)
        return 0

    async def write(self, address: int, value: int) -> None:
        """Write a register."""
        self._add(Operation.WRITE, address=address, value=value)

    async def read_memory(self, address: int, size: int) -> bytes:
        """Send a region."""
        self._add(Operation.FRAME, value=header(region_kind(self._regions[address]), size))
        self._add(Operation.BYTES, address=address, value=size)
        self._add(Operation.CHECK)
        return bytes(size)

    async def write_memory(self, address: int, data: bytes) -> None:
        """The initial contents of memory: the image, once."""
        if address or self.memory:
            raise ValueError("Memory must be written once, from address 0 on")
        self.memory = data

    async def wait(self, cycles: int) -> None:
        """Never called: the recorded machine is never busy."""
        raise AssertionError("the recorded machine must not be busy")

    def framed(self, kind: FrameKind) -> list[Step]:
        """All steps, with a frame of that kind around consecutive registers that are sent."""
        found = []
        for sent, steps in groupby(self.steps, key=lambda step: step.operation is Operation.WORD):
            steps = list(steps)
            found += [Step(operation=Operation.FRAME, value=header(kind.value, WORD_BYTES * len(steps))), *steps,
                      Step(operation=Operation.CHECK)] if sent else steps
        return [*found, Step(operation=Operation.HALT)]


def record(image: MemoryImage, config: Config, *, total: int = 0) -> Program:
    """The accesses of `hw.host.Host` that cast the frustum of an image, or report an error.

    Cycles, frustum, hits and sums are sent, or code, cluster and address of an error.

    Parameters
    ----------
    total
        The sum of the weights of all rays.

    Raises
    ------
    InputError
        The image exceeds a capacity of the machine.
    """
    offsets = image.offsets
    usual = _Recorder(config, regions={offsets[name]: name for name in _SENT})
    failed = _Recorder(config, fails=True)

    async def cast():
        host = Host(usual, config)
        await host.identify()
        await host.load(image)
        await host.cast()
        await usual.read_memory(offsets["frustum"], image["frustum"].nbytes)
        await host.results(total=total)

    async def tell():
        try:
            await Host(failed, config).finish("casts", timeout=0)
        except EngineError:
            return
        raise AssertionError("the driver must notice that the machine has failed")

    asyncio.run(cast())
    asyncio.run(tell())
    steps = usual.framed(FrameKind.CYCLES)
    return Program(steps=(*steps, *failed.framed(FrameKind.ERROR)), error=len(steps), memory=usual.memory)
