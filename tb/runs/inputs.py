"""What a shard depends on: the files that its last run opened, and all that no Python opens by itself."""

import hashlib
import os
import re
import subprocess
from collections.abc import Iterable, Mapping
from pathlib import Path

from tb.runs.ledger import LEDGER
from tb.runs.shard import READERS, Shard

__all__ = ["Inputs", "commit_of", "watched"]

_WATCH = Path(__file__).parent / "reads"
_COMPILED = re.compile(r"__pycache__/(\w+)\.[^/]*$")
# Letters of a file's code in an entry. Two files of one code are both taken for read.
_LETTERS = 4


class Inputs:
    """Digests of the files of a commit that shards depend on.

    These are all but the ledger, the changelog, and modules and pages that no process of the shard's tests opened. So
    a shard that is green stays so while others change, and for the commit that records it. Shards of `READERS`, whose
    tests look for files, depend on all of them.

    Parameters
    ----------
    folder
        The checkout.
    shards
        All that a digest may be of.
    """

    def __init__(self, folder: Path, shards: Iterable[Shard]):
        self._is_clean = not commit_of(folder).endswith("+")
        self._lines = {path: line for line in _git(folder, "ls-tree", "-r", "HEAD").splitlines()
                       if (path := line.split("\t")[1]) not in (LEDGER, "CHANGELOG.md")}
        self._own = {shard.name: {path.relative_to(folder).as_posix() for path in shard.files} for shard in shards}

    def digest(self, shard: str, reads: str) -> str:
        """A digest for a run of a shard; empty if files differ from the commit, or the shard is none of ours.

        Parameters
        ----------
        shard
            Its name.
        reads
            What the run opened, as `reads` gives it.
        """
        if not self._is_clean or shard not in self._own:
            return ""
        codes, all_count = {*map("".join, zip(*[iter(reads)] * _LETTERS, strict=True))}, shard.split("/")[0] in READERS
        return hashlib.sha256("\n".join(
            line for path, line in self._lines.items()
            if all_count or path in self._own[shard] or not _is_watched(path) or _code(path) in codes)
            .encode()).hexdigest()[:16]

    def reads(self, log: Path) -> str:
        """Codes of the commit's modules and pages that a log of `watched` names."""
        opened = {_COMPILED.sub(r"\1.py", path)
                  for path in (log.read_text().splitlines() if log.exists() else ())}
        return "".join(sorted({_code(path) for path in opened if path in self._lines and _is_watched(path)}))


def watched(environment: Mapping[str, str], root: Path, log: Path) -> dict[str, str]:
    """An environment whose Python processes log the files below a root that they open."""
    return {**environment, "READS_ROOT": str(root), "READS_LOG": str(log),
            "PYTHONPATH": os.pathsep.join(filter(None, [str(_WATCH), environment.get("PYTHONPATH")]))}


def commit_of(folder: Path) -> str:
    """The hash of the commit that is checked out, and ``+`` if files but the ledger differ from it."""
    changed = _git(folder, "status", "--porcelain", "--", ".", f":(exclude){LEDGER}")
    return _git(folder, "rev-parse", "HEAD").strip() + ("+" if changed else "")


def _is_watched(path):
    """Whether a file is a module or of the documentation; what else there is compilers may read, which log nothing."""
    return path.endswith((".py", ".md")) or path.startswith("docs/")


def _code(path):
    return hashlib.sha256(path.encode()).hexdigest()[:_LETTERS]


def _git(folder, *words):
    return subprocess.run(["git", *words], cwd=folder, capture_output=True, text=True, check=True).stdout
