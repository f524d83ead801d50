"""Memory of this process."""

import re
import resource
import sys
from pathlib import Path

__all__ = ["peak_memory"]


def peak_memory() -> int:
    """The most bytes that this process has had.

    On Linux the usage of resources also has those of the process that started this one, so the kernel's own status is
    read.
    """
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
    except OSError:  # there is none on other systems
        status = ""
    found = re.search(r"(?m)^VmHWM:\s*(\d+) kB$", status)
    if found:
        return 1024 * int(found[1])
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
