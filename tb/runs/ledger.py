"""The ledger of the nightly: which shard ran on which commit, with what tools, for how long, and how it ended."""

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

__all__ = ["LEDGER", "Entry", "Ledger"]

# Committed, so that several machines and sittings add to it.
LEDGER = "tb/runs/ledger.jsonl"


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One run of a shard.

    Parameters
    ----------
    shard
        Its name.
    commit
        The hash of the commit; with ``+`` behind it, files differed.
    inputs
        A digest of all files that it depends on; empty if files differed.
    reads
        Codes of the modules and pages that it opened.
    seed
        What the tests drew from.
    versions
        Of the tools, by name.
    began
        Local time, ISO 8601.
    wall, cpu
        Seconds; the CPU's are those of all processes.
    passed, failed, skipped
        Numbers of tests; an error counts as failed.
    result
        ``green``; ``red``; ``late``: it was ended after the most minutes of a shard.
    """

    shard: str
    commit: str
    inputs: str
    reads: str
    seed: int
    versions: dict[str, str]
    began: str
    wall: float
    cpu: float
    passed: int
    failed: int
    skipped: int
    result: str


class Ledger:
    """A file of entries, one JSON object per line; a run only appends.

    Parameters
    ----------
    path
        The file; it need not exist.

    Raises
    ------
    ValueError
        A line is no entry.
    """

    def __init__(self, path: Path):
        self._path = path
        self.entries: list[Entry] = []
        for number, line in enumerate(path.read_text().splitlines() if path.exists() else (), 1):
            try:
                self.entries.append(Entry(**json.loads(line)))
            except (TypeError, json.JSONDecodeError) as error:
                raise ValueError(f"{path}, line {number}: no entry of a ledger") from error

    def add(self, entry: Entry) -> None:
        """Append an entry, to the file too."""
        self.entries.append(entry)
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a") as file:
            file.write(json.dumps(asdict(entry)) + "\n")

    def missing(self, names: Iterable[str], digest: Callable[[str, str], str]) -> list[str]:
        """Of some shards those whose newest entry for what a commit holds is not green, in order.

        Parameters
        ----------
        names
            Names of the shards.
        digest
            Of a shard's name and what its run read, the digest of the inputs that the commit has.
        """
        newest = self._newest(digest)
        return [shard for shard in names if shard not in newest or newest[shard].result != "green"]

    def table(self, names: Iterable[str], digest: Callable[[str, str], str]) -> str:
        """What the newest entries of some shards for what a commit holds say, as Markdown."""
        newest = self._newest(digest)
        rows = [[shard, *(("-",) * 7 if shard not in newest else _row(newest[shard]))] for shard in names]
        head = ["shard", "result", "passed", "failed", "min", "CPU min", "seed", "commit"]
        return "\n".join(f"| {' | '.join(row)} |" for row in [head, ["---"] * len(head), *rows])

    def _newest(self, digest):
        return {entry.shard: entry for entry in self.entries
                if entry.inputs and digest(entry.shard, entry.reads) == entry.inputs}


def _row(entry):
    return (entry.result, str(entry.passed), str(entry.failed), f"{entry.wall / 60:.1f}", f"{entry.cpu / 60:.1f}",
            str(entry.seed), entry.commit[:10])
