"""A job that lies in main memory as a whole before its doorbell."""

from collections.abc import Sequence

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.jobs.job import Job, PhaseRequest, plan_job
from golden.engine.memory_map.image_layout import aligned

__all__ = ["memory_before", "whole_job"]


def whole_job(requests: Sequence[PhaseRequest], config: Config, *, base: int = 0) -> Job:
    """The job of `plan_job`, in rings with an entry for each descriptor.

    Parameters
    ----------
    requests, config, base
        As for `plan_job`; the machine holds nothing before.

    Raises
    ------
    InputError
        As `plan_job`; or the job ends beyond the addresses of the machine.
    """
    bits = (len(plan_job(requests, config, ring_bits=0).descriptors) - 1).bit_length()
    end, most = aligned(base) + plan_job(requests, config, ring_bits=bits).end, 1 << config.memory.address_bits
    if end > most:
        raise InputError(f"job: Memory must end at {most:#x} (memory.address_bits), not {end:#x}", parameter="memory")
    return plan_job(requests, config, ring_bits=bits, base=base)


def memory_before(job: Job) -> bytes:
    """Main memory from ``job.base`` on before the first doorbell after a reset: rings, tables, cells of shell 1.

    It ends with the last table; from there to ``job.end`` memory is for results, whatever it holds.

    Raises
    ------
    ValueError
        The ring has fewer entries than the job has descriptors.
    """
    if len(job.descriptors) > 1 << job.ring_bits:
        raise ValueError(f"The ring must have {len(job.descriptors)} entries, not {1 << job.ring_bits}")
    written = {job.ring: job.descriptors.tobytes(), **job.tables()}
    memory = bytearray(max(address + len(data) for address, data in written.items()) - job.base)
    for address, data in written.items():
        memory[address - job.base:address - job.base + len(data)] = data
    return bytes(memory)
