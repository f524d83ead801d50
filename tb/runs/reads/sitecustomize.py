"""Found in ``PYTHONPATH`` by each Python that starts: append what it opens below ``READS_ROOT`` to ``READS_LOG``."""

import os
import sys


def _watch(root, log):
    seen = set()

    def note(event, arguments):
        if event == "open" and isinstance(arguments[0], str | bytes | os.PathLike):
            path = os.path.abspath(os.fsdecode(arguments[0]))
            if path.startswith(root) and path not in seen:
                seen.add(path)
                os.write(log, f"{path[len(root):]}\n".encode())

    sys.addaudithook(note)
    note("open", (__file__,))


if "READS_LOG" in os.environ:
    _watch(os.path.join(os.environ["READS_ROOT"], ""),
           os.open(os.environ["READS_LOG"], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644))
