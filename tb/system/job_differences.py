"""What a machine has left of a job, beside what golden says."""

from collections.abc import Mapping

import numpy as np

from golden.engine.jobs.job import Read
from golden.engine.jobs.run_job import JobResults

__all__ = ["job_differences"]


def job_differences(expected: JobResults, records: np.ndarray, read: Read, names: Mapping[int, str]) -> list[str]:
    """What a machine has left otherwise than expected, a line each; the order of its completions does not matter.

    Parameters
    ----------
    expected
        What it must leave.
    records
        Its completion records in the order of their numbers.
    read
        Reads main memory after them.
    names
        Names of its error codes.
    """
    found = [f"{len(records)} completions instead of {len(expected.completions)}"] \
        if len(records) != len(expected.completions) else []
    left = {int(one["tag"]): (error, int(one["address"]), int(one["sums"]))
            for one, error in zip(expected.completions, expected.errors, strict=True)}
    for record in records:
        tag, error = int(record["tag"]), names[int(record["error"])]
        if tag not in left:
            found.append(f"tag {tag} is unknown, or completes again")
            continue
        expected_error, address, sums = left.pop(tag)
        if error != expected_error:
            found.append(f"tag {tag}: {error} instead of {expected_error}")
        elif error != "NONE" and record["address"] != address:
            found.append(f"tag {tag}: {error} at {record['address']:#x} instead of {address:#x}")
        elif error == "NONE" and record["sums"] != sums:
            found.append(f"tag {tag}: {record['sums']} words of sums instead of {sums}")
    found += [f"tag {tag} does not complete" for tag in left]
    return found + [f"{len(data)} bytes at {address:#x} are other ones" for address, data in expected.memory.items()
                    if read(address, len(data)) != data]
