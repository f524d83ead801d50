"""A bar for work whose stages cannot say how far they are."""

import json
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from golden.base.output import whole_file
from golden.base.progress_bar import progress_bar

__all__ = ["StageProgress"]

# A stage that takes longer than expected stops the bar short of its end.
_MOST = 0.95

# No stage takes so many seconds.
_LONGEST = 1e7


class StageProgress:
    """Shows which stage of a job runs, and its share of the time that the stages are expected to take.

    Parameters
    ----------
    title
        What the job is.
    expected
        Seconds of each stage on two idle cores.
    shown
        Show the bar on stderr once two seconds have passed.
    record
        A file that keeps the durations of the last job: they replace the expected ones. One that cannot be read counts
        as none, and one that cannot be written stays as it is.
    """

    def __init__(self, title: str, expected: dict[str, float], *, shown: bool, record: Path | None = None):
        self._title, self._record, self._expected, self._taken = title, record, dict(expected), {}
        known = self._known()
        self._expected |= {name: known[name] for name in expected if name in known}
        self._tick = 0.5 if sys.stderr.isatty() else 10.0
        self._total = max(1, round(sum(self._expected.values())))
        self._bar = progress_bar(
            total=self._total, desc=title, disable=not shown, delay=2, miniters=0,
            mininterval=self._tick / 2, bar_format="{desc}{percentage:3.0f}% |{bar}| {elapsed} of about {total} s")
        self._done = 0.0

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """One of the stages."""
        begin, ended = time.monotonic(), threading.Event()
        self._bar.set_description(f"{self._title}: {name}", refresh=False)

        def advance():
            while not ended.wait(self._tick):
                self._show(min(time.monotonic() - begin, _MOST * self._expected[name]))

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
        # The total is rounded: the last stage must not pass it.
        self._bar.update(min(round(self._done + share, 1), self._total) - self._bar.n)

    def keep(self) -> None:
        """Keep the durations, of a complete job, for the next estimate."""
        known = self._known() | {name: round(seconds, 1) for name, seconds in self._taken.items()}
        with suppress(OSError), whole_file(self._record) as part:
            part.write_text(json.dumps(known))

    def _known(self):
        """The recorded durations; none of what a torn file or another program left."""
        try:
            known = json.loads(self._record.read_text()) if self._record else {}
            return {str(name): float(seconds) for name, seconds in known.items() if 0 <= seconds < _LONGEST}
        except (OSError, ValueError, AttributeError, TypeError):
            return {}

    def close(self) -> None:
        """Close the bar."""
        self._bar.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
