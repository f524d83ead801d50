"""A release: what must be green before a commit is tagged."""

import re
import shutil
import subprocess
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tb.runs.inputs import Inputs, commit_of
from tb.runs.ledger import Ledger
from tb.runs.nightly import cpu_seconds
from tb.runs.shard import shards

__all__ = ["STEPS", "NotReadyError", "release"]

# By name: commands that must end with 0 in a clean clone.
STEPS = {
    "test": ["make", "test"],
    "sim": ["make", "sim"],
    "docs": ["make", "docs"],
    # A night has a third of them.
    "exports": ["env", "NIGHTS=3", ".venv/bin/python", "-m", "pytest", "-n", "2", "-q",
                "tb/radiosity/flow/package/test_core_files.py", "-k", "test_all_presets"],
}


class NotReadyError(Exception):
    """A commit may not be tagged; says why in a line."""


@dataclass(frozen=True)
class _Step:
    """A command that passed: its last line, and seconds of wall time and of CPU."""

    said: str
    wall: float
    cpu: float


def release(root: Path, ledger: Ledger, *, report: Callable[[str], object], steps: dict | None = None) -> str:
    """Tag the commit that is checked out with the version of ``pyproject.toml``.

    All shards of the nightly must be green in the ledger for what this commit holds, the changelog must have the
    version, and `STEPS` must pass in a clean clone with empty caches. The tag's message has the changelog's entry, and
    counts and times of steps and shards.

    Parameters
    ----------
    root
        The checkout.
    ledger
        Of the nightly.
    report
        Is given a line before each step.
    steps
        Other steps.

    Returns
    -------
    The tag's name.

    Raises
    ------
    NotReadyError
        Something is missing, or a step fails.
    """
    commit, version = commit_of(root), tomllib.loads((root / "pyproject.toml").read_text())["project"]["version"]
    tag, parts = f"v{version}", shards(root / "tb")
    names, inputs = [shard.name for shard in parts], Inputs(root, parts)
    changes = (root / "CHANGELOG.md").read_text()
    entry = re.search(rf"^## \[{re.escape(version)}\].*?(?=^## \[|\Z)", changes, re.M | re.S)
    if commit.endswith("+"):
        raise NotReadyError("files differ from the commit")
    if subprocess.run(["git", "tag", "--list", tag], cwd=root, capture_output=True, text=True, check=True).stdout:
        raise NotReadyError(f"tag {tag} exists")
    if entry is None:
        raise NotReadyError(f"CHANGELOG.md has no entry for {version}")
    if missing := ledger.missing(names, inputs.digest):
        raise NotReadyError(f"not green in the ledger for {commit[:10]}: {', '.join(missing)}")
    clone = root / "build" / "release"
    shutil.rmtree(clone, ignore_errors=True)
    subprocess.run(["git", "clone", "--quiet", "--no-hardlinks", str(root), str(clone)], check=True)
    passed = {}
    for name, command in (STEPS if steps is None else steps).items():
        report(f"== {' '.join(command)}")
        passed[name] = _passed(name, command, clone)
    lines = [entry.group().strip(), "", *(
        f"{name}: {step.said}; {step.wall:.0f} s, {step.cpu:.0f} CPU s" for name, step in passed.items()),
        "", ledger.table(names, inputs.digest)]
    subprocess.run(["git", "tag", "--annotate", "--cleanup=verbatim", "--message", "\n".join(lines), tag, commit],
                   cwd=root, check=True)
    return tag


def _passed(name, command, folder):
    """A step that passed; what it prints is kept in a file beside the clone."""
    log, begin, used = folder.with_name(f"release-{name}.txt"), time.monotonic(), cpu_seconds()
    with log.open("w") as file:
        code = subprocess.run(command, cwd=folder, stdout=file, stderr=subprocess.STDOUT, check=False).returncode
    if code:
        raise NotReadyError(f"{' '.join(command)} failed; {log} has what it printed")
    said = log.read_text().splitlines()
    return _Step(said[-1].strip("= ") if said else "", time.monotonic() - begin, cpu_seconds() - used)
