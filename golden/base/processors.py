"""The processors that this process may use."""

import math
import os
from pathlib import Path

from golden.base.errors import whole_number

__all__ = ["processors", "threads_of"]

MOST_JOBS = 256
"""Most threads that work may use."""


def processors(root: Path = Path("/")) -> int:
    """Processors that the affinity of this process and the quotas of its control groups leave, at least 1.

    A container and a batch job often have fewer than the machine. A quota of 1.5 processors counts as 2.

    Parameters
    ----------
    root
        The folder in which ``proc`` and ``sys`` are.
    """
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min([allowed, *map(math.ceil, _quotas(root))]))


def threads_of(jobs: int | None) -> int:
    """A number of threads, checked; by default those of `processors`.

    Raises
    ------
    InputError
        It is no whole number from 1 to `MOST_JOBS`.
    """
    if jobs is None:
        return min(processors(), MOST_JOBS)
    return whole_number("Jobs", jobs, 1, MOST_JOBS, parameter="jobs")


def _quotas(root):
    """Processors that each control group of this process, and each above it, may use together."""
    try:
        lines = (root / "proc/self/cgroup").read_text().splitlines()
    except OSError:
        return
    for line in lines:
        _, controllers, own = [*line.split(":", 2), "", ""][:3]
        for mount in ("sys/fs/cgroup", "sys/fs/cgroup/cpu", "sys/fs/cgroup/cpu,cpuacct"):
            if controllers and "cpu" not in controllers.split(","):
                continue
            folder = root / mount / own.lstrip("/")
            while folder.is_relative_to(root / mount):
                yield from (quota for quota in (_quota(folder),) if quota is not None)
                folder = folder.parent


def _quota(folder):
    """The quota over its period; None without one."""
    try:
        if (folder / "cpu.max").exists():
            quota, period = (folder / "cpu.max").read_text().split()
        else:
            quota, period = ((folder / f"cpu.cfs_{name}_us").read_text() for name in ("quota", "period"))
        quota, period = int(quota), int(period)
    except (OSError, ValueError):  # "max" is no number
        return None
    return quota / period if quota > 0 and period > 0 else None
