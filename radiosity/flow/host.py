"""The host's side of a queue: descriptors into their ring, completion records out of theirs."""

from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Iterable, Sequence

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.jobs.completion import COMPLETION, NO_CLUSTER, parse_completions
from golden.engine.jobs.job import Job
from hw.cluster import COUNTERS
from hw.memsys.bus.cache_policy import CachePolicy
from hw.registers.engine_registers import (
    COUNTER_BITS,
    COUNTERS_BASE,
    ENGINE_REGISTERS,
    MAGIC,
    VERSION,
    register,
)
from hw.registers.error_code import ABOUT, ErrorCode
from hw.registers.register import WORD_BYTES, addresses

__all__ = ["POLL", "EngineError", "EngineTimeoutError", "Host", "Port", "RegisterError", "check_completions"]

_WORD = 1 << 32
# Cycles between two reads of the status.
POLL = 100


class EngineError(Exception):
    """The machine has reported an error.

    Parameters
    ----------
    code, cluster, address
        The registers ``error``, ``error_cluster`` and ``error_address``, or those fields of a completion record.
    work
        The descriptor that has failed, if it is known.
    """

    def __init__(self, code: ErrorCode, cluster: int, address: int, *, work: str = ""):
        where = f"{'no cluster' if cluster == NO_CLUSTER else f'cluster {cluster}'}, at {address:#x}"
        super().__init__(f"{work and f'{work}: '}{code.name}: {ABOUT[code.name]} ({where})")
        self.code, self.cluster, self.address, self.work = code, cluster, address, work


class EngineTimeoutError(Exception):
    """The machine has not answered within the limit."""


class RegisterError(Exception):
    """A register access has been answered with an error response."""


def check_completions(job: Job, records: np.ndarray) -> None:
    """Refuse completion records with errors.

    Raises
    ------
    EngineError
        That of the first record with an error.
    """
    failed = records[records["error"] != ErrorCode.NONE.value]
    if len(failed):
        raise EngineError(ErrorCode(int(failed["error"][0])), int(failed["cluster"][0]), int(failed["address"][0]),
                          work=job.name(int(failed["tag"][0])))


class Port(ABC):
    """The connection between host and machine. Addresses are of bytes; registers have 32 bits."""

    @abstractmethod
    async def read(self, address: int) -> int:
        """A register."""

    @abstractmethod
    async def write(self, address: int, value: int) -> None:
        """Write a register."""

    @abstractmethod
    async def read_memory(self, address: int, size: int) -> bytes:
        """Bytes of main memory."""

    @abstractmethod
    async def write_memory(self, address: int, data: bytes) -> None:
        """Write bytes of main memory."""

    @abstractmethod
    async def wait(self, cycles: int) -> None:
        """Let about so many cycles pass."""


class Host:
    """A driver of one machine with a queue.

    Parameters
    ----------
    port
        The connection to it.
    config
        Its configuration.
    """

    def __init__(self, port: Port, config: Config):
        self._port, self._config, self._addresses = port, config, addresses(ENGINE_REGISTERS)
        self._submitted = self._collected = 0
        # By the address of an image: the tables of cluster 0 are those of all clusters.
        self._copies = {}

    async def read(self, name: str) -> int:
        """A register."""
        first = self._addresses[name]
        words = [await self._port.read(first + WORD_BYTES * k) for k in range(register(name).words)]
        return sum(word << 32 * k for k, word in enumerate(words))

    async def write(self, name: str, value: int) -> None:
        """Write a register.

        Raises
        ------
        ValueError
            The value is out of the register's range.
        """
        if not 0 <= value < 1 << register(name).width:
            raise ValueError(f"{name} must be from 0 to {(1 << register(name).width) - 1}, not {value!r}")
        for k in range(register(name).words):
            await self._port.write(self._addresses[name] + WORD_BYTES * k, value >> 32 * k & _WORD - 1)

    async def status(self) -> dict[str, int]:
        """The fields of the register ``status``."""
        return register("status").unpack(await self.read("status"))

    async def identify(self) -> None:
        """Make sure that this is the machine of the configuration.

        Raises
        ------
        InputError
            It is none, or another one.
        """
        for name, expected in (("magic", MAGIC), ("version", VERSION), ("clusters", self._config.noc.clusters)):
            found = await self.read(name)
            if found != expected:
                raise InputError(f"host: The machine's {name} must be {expected:#x}, not {found:#x}")

    async def begin(self, job: Job, *, window: tuple[int, int] | None = None,
                    policy: CachePolicy | None = None) -> None:
        """Write a job's tables, and give the machine its rings. Nothing may be in flight.

        Parameters
        ----------
        job
            The job.
        window
            First byte that the machine may read and write, and the byte after the last one. Default: the job's.
        policy
            Of the caches. Default: the configuration's.
        """
        for address, data in job.tables().items():
            await self._port.write_memory(address, data)
        self._copies |= {phase.address: phase.image.has_copies for phase in job.phases}
        self._submitted, self._collected = await self.read("taken"), await self.read("completed")
        # What a halted queue has not taken is dropped.
        await self.write("doorbell", self._submitted)
        entries = COMPLETION.dtype.itemsize << job.ring_bits
        await self._port.write_memory(job.completions, bytes(entries))
        base, limit = window or (job.base, job.end)
        policy = policy or CachePolicy[self._config.memsys.cache_policy.upper()]
        for name, value in (("ring", job.ring), ("completions", job.completions), ("ring_bits", job.ring_bits),
                            ("read_base", base), ("read_limit", limit), ("write_base", base), ("write_limit", limit),
                            ("policy", policy.value)):
            await self.write(name, value)

    async def submit(self, job: Job, descriptors: Sequence[np.void]) -> None:
        """Put descriptors into the ring, and ring the doorbell. At most `free_entries` of them."""
        for descriptor in descriptors:
            await self._port.write_memory(job.entry(self._submitted), descriptor.tobytes())
            self._submitted += 1
        await self.write("doorbell", self._submitted % _WORD)

    def free_entries(self, job: Job) -> int:
        """Descriptors that can be submitted now."""
        return (1 << job.ring_bits) - (self._submitted - self._collected)

    async def collect(self, job: Job) -> np.ndarray:
        """The completion records that have come since the last call, in their order.

        Raises
        ------
        InputError
            The machine has completed more than was submitted: it was reset.
        """
        found = await self._arrived(job)
        self._collected += len(found)
        return found

    async def _arrived(self, job):
        """The records that `collect` is about to return."""
        first, size = self._collected, COMPLETION.dtype.itemsize
        completed = await self.read("completed")
        count = (completed - first) % _WORD
        if count > self._submitted - first:
            raise InputError(f"host: The machine's completed must be at most {self._submitted % _WORD}, not "
                             f"{completed}: it was reset, so a job must begin anew")
        ring = parse_completions(await self._port.read_memory(job.completions, size << job.ring_bits))
        return ring[[number % len(ring) for number in range(first, first + count)]]

    async def run(self, job: Job, descriptors: np.ndarray | None = None, *, timeout: int = 1 << 26,
                  watch: Callable[[int], Awaitable[None]] | None = None) -> np.ndarray:
        """Run a job that `begin` has prepared, and return its completion records in their order.

        Parameters
        ----------
        job
            The job.
        descriptors
            Descriptors instead of the job's.
        timeout
            Cycles without a completion record after which the machine has failed.
        watch
            Awaited after the doorbell and before each further poll, with the number of completion records so far.

        Raises
        ------
        EngineError
            The queue has halted; the error names the descriptor that has caused it, if there is one, and a completion
            record that cannot be written. The records of what was in flight are in the ring, see `collect`.
        EngineTimeoutError
            It takes longer.
        InputError
            See `collect`.
        """
        waiting = list(job.descriptors if descriptors is None else descriptors)
        count, records, idle = len(waiting), [], 0
        while len(records) < count:
            free = self.free_entries(job)
            if waiting and free:
                await self.submit(job, waiting[:free])
                waiting = waiting[free:]
            if watch:
                await watch(len(records))
            found = await self.collect(job)
            records += list(found)
            idle = 0 if len(found) else idle + POLL
            if idle >= timeout:
                raise EngineTimeoutError(f"the machine has completed {len(records)} of {count} descriptors, and none "
                                         f"for {idle} cycles")
            status = await self.status()
            # A record that cannot be written stays in flight until a resume.
            if status["halted"] and not status["stops"] and (status["unwritten"] or not status["busy"]):
                raise await self._error(job, records)
            await self._port.wait(POLL)
        return np.array(records, dtype=COMPLETION.dtype)

    async def _error(self, job=None, records=()):
        """That of the machine; of a job it names the descriptor that has ended in the same error, and a record that
        cannot be written.
        """
        code, work = ErrorCode(await self.read("error")), []
        for record in [*records, *await self._arrived(job)] if job else []:
            if record["error"] == code.value and record["tag"] < len(job.sections):
                work = [job.name(int(record["tag"]))]
        if (await self.status())["unwritten"]:
            work.append(f"completion record {await self.read('completed')} cannot be written")
        return EngineError(code, await self.read("error_cluster"), await self.read("error_address"),
                           work=", ".join(work))

    async def command(self, *names: str) -> None:
        """One of the register ``command``, and ``copies`` of a resume."""
        await self.write("command", register("command").pack(**dict.fromkeys(names, 1)))

    async def resume(self, image: int, *, timeout: int = 1 << 20) -> None:
        """Clear the error of a halted queue, load all regions of the image at ``image``, and let the queue go on.

        The image is that of a phase of a job that has begun on this machine.

        Raises
        ------
        EngineError
            The load has failed.
        EngineTimeoutError
            It takes longer.
        """
        await self.write("image", image)
        await self.command("clear")
        await self.command("resume", *(["copies"] if self._copies.get(image) else []))
        waited = 0
        # Nothing is loaded while the queue is halted.
        while not (status := await self.status())["loaded"]:
            if status["halted"] and status["failed"]:
                raise await self._error()
            if waited >= timeout:
                what = "halted" if status["halted"] else "loading"
                raise EngineTimeoutError(f"the queue is still {what} after {waited} cycles")
            await self._port.wait(POLL)
            waited += POLL

    async def counters(self, names: Iterable[str] = COUNTERS) -> list[dict[str, int]]:
        """Counters of each cluster, of `hw.cluster.COUNTERS`."""
        found, indices = [], {name: index for index, name in enumerate(COUNTERS)}
        for cluster in range(self._config.noc.clusters):
            first = COUNTERS_BASE + WORD_BYTES * (cluster << COUNTER_BITS)
            found.append({name: await self._port.read(first + WORD_BYTES * indices[name]) for name in names})
        return found
