"""Main memory after a job: each byte of it."""

from collections.abc import Collection, Mapping

import numpy as np

from golden.engine.frustum.bundle import Bundle
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.jobs.job import Job
from golden.engine.jobs.result_formats import HitFormat, bit_words
from golden.engine.jobs.run_job import run_job
from hw.registers.error_code import ErrorCode

__all__ = ["JobMemory"]

# With these a section ends after results of it may have been written.
_PARTLY = {ErrorCode[name] for name in (
    "WRITE_OUTSIDE", "WRITE_REPLY", "WRITE_TIMEOUT", "WRITE_PROTOCOL", "PATH_TIMEOUT", "WATCHDOG", "ABORTED")}


class JobMemory:
    """Brute force's results of a job.

    Parameters
    ----------
    job
        The job.
    descriptors
        Descriptors in place of the job's, see `run_job`.
    """

    def __init__(self, job: Job, descriptors: np.ndarray | None = None):
        self.job = job
        self.descriptors = job.descriptors if descriptors is None else descriptors
        self.expected = run_job(job, descriptors, brute_force=True)

    def check(self, before: bytes, after: bytes, records: np.ndarray, *, base: int,
              errors: Mapping[int, ErrorCode] | None = None, undefined: Collection[int] = ()) -> None:
        """Each descriptor completes once, hits and sums are brute force's, and no other byte has changed.

        Parameters
        ----------
        before, after
            Main memory from ``base`` on.
        records
            All completion records.
        errors
            Codes of the descriptors that golden would execute, by tag.
        undefined
            Tags of sections whose results may be anything.
        """
        errors = {tag: ErrorCode[code] for tag, code in enumerate(self.expected.errors) if code != "NONE"} | (
            dict(errors or {}))
        assert sorted(records["tag"].tolist()) == list(range(len(self.descriptors))), "each descriptor completes once"
        for record in records:
            tag, code = int(record["tag"]), ErrorCode(int(record["error"]))
            assert code is errors.get(tag, ErrorCode.NONE), f"descriptor {tag} completes with {code.name}"
            expected = self.expected.completions[tag]
            if code is ErrorCode.NONE and tag not in undefined:
                assert record["sums"] == expected["sums"], f"words of sums of descriptor {tag}"
            elif self.expected.errors[tag] == code.name:
                assert record["address"] == expected["address"], f"descriptor {tag}: {code.name}"
        # A malformed descriptor's rows may be where those of a good one are.
        good = {address for tag in range(len(self.descriptors)) if tag not in errors
                for address in self._addresses(tag)}
        without = {address for tag in errors for address in self._addresses(tag)} - good
        partly = {address for tag, code in errors.items() if code in _PARTLY for address in self._addresses(tag)}
        expected, job = bytearray(before), self.job
        for first, entry in (job.ring, DESCRIPTOR), (job.completions, COMPLETION):
            extent = slice(first - base, first - base + (entry.dtype.itemsize << job.ring_bits))
            expected[extent] = after[extent]
        # Of sums of which one overflows some are written.
        undefined = {*undefined} | {tag for tag, code in errors.items() if code is ErrorCode.OVERFLOW}
        for first, size in (one for tag in undefined for one in self._extents(tag)):
            extent = slice(first - base, first - base + size)
            expected[extent] = after[extent]
        partly |= {first for tag in undefined for first in self._addresses(tag)}
        for address, data in self.expected.memory.items():
            extent = slice(address - base, address - base + len(data))
            if address in partly:
                both = zip(after[extent], data, expected[extent], strict=True)
                assert all(now in (new, old) for now, new, old in both), f"results at {address:#x}"
                expected[extent] = after[extent]
            elif address not in without:
                expected[extent] = data
        wrong = np.flatnonzero(np.frombuffer(after, np.uint8) != np.frombuffer(expected, np.uint8))
        assert not len(wrong), f"{len(wrong)} bytes of main memory are wrong, the first at {base + wrong[0]:#x}"

    def _addresses(self, tag):
        """Where golden's results of a section begin."""
        return [first for first, _ in self._extents(tag)]

    def _extents(self, tag):
        """First byte and size of the results of a section, row by row, as many as there can be; of a shadow frustum
        those of its bits.
        """
        one, section = self.descriptors[tag], self.job.sections[tag]
        first_column, end_column, first_row, end_row = (
            int(one[name]) for name in ("first_column", "end_column", "first_row", "end_row"))
        columns, rays = int(one["columns"]), max(0, end_column - first_column) * max(0, end_row - first_row)
        if one["sums"] and section:
            patches = len(self.job.phases[section.phase].request.geometry)
            yield int(one["sums_address"]), 8 * min(rays, patches)
        if one["bundle"] == Bundle.SHADOW:
            yield int(one["hits"]), 8 * bit_words(int(one["ray_count"]))
        size = HitFormat(one["hit_format"]).bytes if one["hit_format"] in tuple(HitFormat) else 0
        for row in range(first_row, end_row if size else 0):
            yield int(one["hits"]) + size * (row * columns + first_column), size * (end_column - first_column)
