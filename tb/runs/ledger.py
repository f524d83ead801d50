"""The ledger of the nightly: which shard ran on which commit, with what tools, for how long, and how it ended."""

import json
from collections.abc import Mapping
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

    def missing(self, inputs: Mapping[str, str]) -> list[str]:
        """The shards whose newest entry for their inputs, a digest for each, is not green, in order."""
        newest = self._newest(inputs)
        return [shard for shard in inputs if shard not in newest or newest[shard].result != "green"]

    def table(self, inputs: Mapping[str, str]) -> str:
        """What the newest entries for such inputs say, as Markdown."""
        newest = self._newest(inputs)
        rows = [[shard, *(("-",) * 7 if shard not in newest else _row(newest[shard]))] for shard in inputs]
        head = ["shard", "result", "passed", "failed", "min", "CPU min", "seed", "commit"]
        return "\n".join(f"| {' | '.join(row)} |" for row in [head, ["---"] * len(head), *rows])

    def _newest(self, inputs):
        return {entry.shard: entry for entry in self.entries
                if entry.inputs and inputs.get(entry.shard) == entry.inputs}


def _row(entry):
    return (entry.result, str(entry.passed), str(entry.failed), f"{entry.wall / 60:.1f}", f"{entry.cpu / 60:.1f}",
            str(entry.seed), entry.commit[:10])
