"""What main memory holds after a job, without cycles."""

from dataclasses import dataclass

import numpy as np

from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling
from golden.engine.frustum.bundle import Bundle
from golden.engine.icu.patch_sums import section_sums
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR, Kind, check_descriptor, section_of
from golden.engine.jobs.job import Job
from golden.engine.jobs.load_regions import LOADED_REGIONS, region_bits
from golden.engine.jobs.result_formats import (
    HitFormat,
    ResultCommand,
    pack_bits,
    pack_sums,
    result_bytes,
    section_rays,
)

__all__ = ["JobResults", "run_job"]


@dataclass(frozen=True, kw_only=True, eq=False)
class JobResults:
    """What a machine leaves of a job. The order in which sections complete does not matter.

    Parameters
    ----------
    memory
        The results: bytes by the address of the first of them. Nothing else is written but completion records.
    completions
        D records of `COMPLETION`, one for each descriptor in the order of their numbers, with ``tag``, ``address`` and
        ``sums``; the other fields are 0: they depend on the order, on cycles or on the encoding of errors.
    errors
        Name of the error code of each descriptor. The results of a section with an error are undefined.
    """

    memory: dict[int, bytes]
    completions: np.ndarray
    errors: tuple[str, ...]


def run_job(job: Job, descriptors: np.ndarray | None = None, *, brute_force: bool = False) -> JobResults:
    """The results of a job.

    Parameters
    ----------
    job
        The job.
    descriptors
        Descriptors instead of the job's, for example malformed ones. One that the machine executes is of the frustum
        that the job has at the same number, or the load of an image of the job.
    brute_force
        Casts with `NaiveFixed` instead of `Shelling`. The hits are the same.
    """
    descriptors = job.descriptors if descriptors is None else descriptors
    completions = np.zeros(len(descriptors), dtype=COMPLETION.dtype)
    machine, memory, errors = _Machine(job, brute_force), {}, []
    for number, descriptor in enumerate(descriptors):
        written, error, address, sums = machine.execute(number, descriptor)
        memory |= written
        errors.append(error)
        completions[number]["tag"], completions[number]["address"] = descriptor["tag"], address
        completions[number]["sums"] = sums
    return JobResults(memory=memory, completions=completions, errors=tuple(errors))


class _Machine:
    """What descriptors leave behind: the tables loaded. Hits of a frustum are kept, since its sections share them."""

    def __init__(self, job, brute_force):
        self._job, self._brute_force = job, brute_force
        self._images = {phase.address: phase.image for phase in job.phases}
        self._loaded, self._last_shell, self._weights = False, 0, None
        self._hits, self._casters = {}, {}

    def execute(self, number, descriptor):
        """Bytes by address; the error, and the number concerned by it; words of sums."""
        refusal = check_descriptor(descriptor, self._job.config)
        if refusal:
            return {}, refusal.code, refusal.byte, 0
        if descriptor["kind"] == Kind.LOAD:
            return self._load(int(descriptor["hits"]), int(descriptor["regions"]))
        if not self._loaded:
            return {}, "NOT_LOADED", 0, 0
        if descriptor["last_shell"] > self._last_shell:
            return {}, "NOT_LOADED", DESCRIPTOR.dtype.fields["last_shell"][1], 0
        one = self._job.sections[number]
        if descriptor["bundle"] == Bundle.SHADOW:
            return {int(descriptor["hits"]): pack_bits(self._bits(one, descriptor))}, "NONE", 0, 0
        return self._cast(one, descriptor)

    def _load(self, address, regions):
        if address not in self._images:
            self._loaded = False
            return {}, "IMAGE", address, 0
        self._loaded |= regions & LOADED_REGIONS == LOADED_REGIONS
        if regions & region_bits("shells"):
            self._last_shell = self._images[address].last_shell
        if regions & region_bits("rows"):
            self._weights = self._images[address]["rows"]["weight"].astype(np.int64)
        return {}, "NONE", 0, 0

    def _cast(self, one, descriptor):
        command = ResultCommand(
            hit_format=HitFormat(descriptor["hit_format"]), sums=bool(descriptor["sums"]), hits=int(descriptor["hits"]),
            sums_address=int(descriptor["sums_address"]), columns=int(descriptor["columns"]),
            section=section_of(descriptor))
        rays = section_rays(command.section, command.columns)
        cast = self._frustum(one.phase, one.frustum)
        hits = FixedHits(**{name: values[rays] for name, values in vars(cast).items()})
        sums = section_sums(hits.patch, self._weights[rays // command.columns])
        if command.sums and sums.overflow >= 0:
            return {}, "OVERFLOW", sums.overflow, 0
        words = pack_sums(sums.patch, sums.sum) if command.sums else np.zeros(0, dtype="<u8")
        return result_bytes(command, hits, words), "NONE", 0, len(words)

    def _bits(self, one, descriptor):
        """Whether each ray of the job's list is blocked; none is that the descriptor has beside its section."""
        record = self._job.phases[one.phase].request.records[one.frustum]
        rays = one.section.among(record.listed, record)[:descriptor["ray_count"]]
        return self._frustum(one.phase, one.frustum)[rays] & section_of(descriptor).mask(record).ravel()[rays]

    def _frustum(self, phase, frustum):
        """The hits of a frustum; of a shadow frustum, whether each ray is blocked."""
        if (phase, frustum) not in self._hits:
            record = self._job.phases[phase].request.records[frustum]
            caster = self._caster(phase, len(record))
            hits = caster.blocked(record) if record.bundle == Bundle.SHADOW else caster.cast(record)
            # Shelling adds its counts.
            self._hits[phase, frustum] = hits if self._brute_force else hits[0]
        return self._hits[phase, frustum]

    def _caster(self, phase, rays):
        """Casts whole frusta, also those that are larger than a cluster's ray memory."""
        if phase not in self._casters:
            config, request = self._job.config.for_rays(rays), self._job.phases[phase].request
            self._casters[phase] = NaiveFixed(request.geometry, config) if self._brute_force else Shelling.of_cells(
                request.geometry, request.table, config)
        return self._casters[phase]
