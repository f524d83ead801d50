"""The results of a job as text, for comparison with what a machine has written."""

from collections.abc import Iterator

import numpy as np

from golden.engine.jobs.job import Job
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.run_job import run_job

__all__ = ["expected_results"]


def expected_results(job: Job) -> Iterator[str]:
    """A line for each hit and each sum, frustum by frustum.

    ``hit FRUSTUM COLUMN ROW PATCH INVERSE U V``, row by row; without the last three numbers where the machine writes
    patches alone. Patch -1 is no hit. ``sum FRUSTUM PATCH SUM`` for each patch with a sum that is not 0, by its number.
    """
    results = run_job(job)
    memory = np.zeros(job.end - job.base, dtype=np.uint8)
    for address, data in results.memory.items():
        memory[address - job.base:address - job.base + len(data)] = np.frombuffer(data, dtype=np.uint8)
    words = {int(one["tag"]): int(one["sums"]) for one in results.completions}

    def read(address, size):
        return memory[address - job.base:address - job.base + size].tobytes()

    for number, phase in enumerate(job.phases):
        for frustum, record in enumerate(phase.request.records):
            if phase.request.hit_format != HitFormat.NONE:
                yield from _hits(frustum, record.columns, job.hits(number, frustum, read))
            if phase.request.sums:
                sums = job.sums(number, frustum, read, words)
                yield from (f"sum {frustum} {patch} {sums[patch]}" for patch in np.flatnonzero(sums))


def _hits(frustum, columns, hits):
    values = [hits] if isinstance(hits, np.ndarray) else [hits.patch, hits.inverse, hits.u, hits.v]
    for ray, numbers in enumerate(np.stack(values, axis=1).tolist()):
        yield " ".join(map(str, ("hit", frustum, ray % columns, ray // columns, *numbers)))
