"""A bar for the build of a simulator, with an estimate from the build before."""

import json
import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tqdm import tqdm

__all__ = ["BuildProgress"]

# Seconds of each stage on two idle cores, until a build has been measured here.
_EXPECTED = {"export Verilog": 12.0, "run Verilator": 14.0, "compile": 18.0}
# A stage that takes longer than expected stops the bar short of its end.
_MOST = 0.95


class BuildProgress:
    """Shows which stage of a build runs, and how far it is by the durations of the last build.

    Parameters
    ----------
    record
        The file that keeps the durations, and exists in a folder of builds.
    shown
        Show the bar on stderr; otherwise only measure.
    """

    def __init__(self, record: Path, *, shown: bool):
        self._record, self._expected, self._taken = record, dict(_EXPECTED), {}
        if record.exists():
            self._expected |= {name: seconds for name, seconds in json.loads(record.read_text()).items()
                               if name in _EXPECTED}
        self._tick = 0.5 if sys.stderr.isatty() else 10.0
        self._bar = tqdm(total=round(sum(self._expected.values())), desc="build the simulator", disable=not shown,
                         delay=2, miniters=0, mininterval=self._tick / 2,
                         bar_format="{desc}{percentage:3.0f}% |{bar}| {elapsed} of about {total} s")
        self._done = 0.0

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """One of the stages."""
        begin, ended = time.monotonic(), threading.Event()
        self._bar.set_description(f"build the simulator: {name}", refresh=False)

        def advance():
            while not ended.wait(self._tick):
                share = min(time.monotonic() - begin, _MOST * self._expected[name])
                self._show(share)

        clock = threading.Thread(target=advance, daemon=True)
        clock.start()
        try:
            yield
        finally:
            ended.set()
            clock.join()
        self._taken[name] = time.monotonic() - begin
        self._done += self._expected[name]
        self._show(0)

    def _show(self, share):
        self._bar.update(round(self._done + share, 1) - self._bar.n)

    def keep(self) -> None:
        """Keep the durations, of a complete build, for the next estimate."""
        part = self._record.with_suffix(f".part{os.getpid()}")
        part.write_text(json.dumps({name: round(seconds, 1) for name, seconds in self._taken.items()}))
        part.replace(self._record)

    def close(self) -> None:
        """Close the bar."""
        self._bar.close()
