"""A shard stays green until a file changes that its run opened, or that other programs may read."""

import os
import subprocess
import sys

import pytest

from tb.runs.checkout import checkout
from tb.runs.inputs import Inputs, commit_of, watched
from tb.runs.ledger import LEDGER
from tb.runs.shard import Shard

FILES = {
    "tb/icu/test_a.py": "import hw.used, subprocess, sys\nsubprocess.run([sys.executable, '-m', 'hw.child'])",
    "hw/used.py": "", "hw/child.py": "open('docs/read.csv').close()", "hw/other.py": "", "tb/icu/bench.py": "",
    "docs/read.csv": "", "docs/other.md": "", "README.md": "", "hw/a.v": "", LEDGER: "", "CHANGELOG.md": ""}


@pytest.fixture
def shard(tmp_path):
    """A project, its shards, and what a run of the first opened: at a second start, from compiled modules."""
    root = checkout(tmp_path / "project", FILES)
    log = root / "out" / "icu.reads"
    log.parent.mkdir()
    for _ in range(2):
        log.unlink(missing_ok=True)
        subprocess.run([sys.executable, "tb/icu/test_a.py"], cwd=root, check=True,
                       env=watched({**os.environ, "PYTHONPATH": str(root)}, root, log))
    shards = [Shard("icu", (root / "tb/icu/test_a.py",)), Shard("docs", ())]
    return root, shards, Inputs(root, shards).reads(log)


@pytest.mark.parametrize(("path", "concerned"), [
    ("hw/used.py", "icu docs"), ("hw/child.py", "icu docs"), ("docs/read.csv", "icu docs"), ("hw/a.v", "icu docs"),
    ("tb/icu/test_a.py", "icu docs"), ("hw/other.py", "docs"), ("tb/icu/bench.py", "docs"), ("docs/other.md", "docs"),
    ("README.md", "docs"), (LEDGER, ""), ("CHANGELOG.md", "")])
def test_a_shard_stays_green_until_what_it_may_read_changes(shard, path, concerned):
    root, shards, reads = shard

    def digests():
        inputs = Inputs(root, shards)
        return {part.name: inputs.digest(part.name, reads) for part in shards}

    before = digests()
    assert all(before.values())
    (root / path).write_text("# Changed.")
    if path != LEDGER:
        assert digests() == {"icu": "", "docs": ""}
    subprocess.run(["git", "commit", "-qam", "Change"], cwd=root, check=True)
    after = digests()
    assert [name for name in before if before[name] != after[name]] == concerned.split()


def test_a_new_test_of_a_shard_changes_its_inputs(shard):
    root, shards, reads = shard
    (root / "tb/icu/test_b.py").write_text("")
    subprocess.run("git add -A; git commit -qm More", shell=True, cwd=root, check=True)
    more = Shard("icu", (*shards[0].files, root / "tb/icu/test_b.py"))
    assert Inputs(root, [more]).digest("icu", reads) != Inputs(root, shards).digest("icu", reads)


def test_an_unknown_shard_has_no_digest(shard):
    root, shards, reads = shard
    assert not Inputs(root, shards[1:]).digest("icu", reads)


def test_a_changed_file_marks_the_commit(tmp_path):
    root = checkout(tmp_path / "project", {"a": "0"})
    commit = commit_of(root)
    (root / "a").write_text("1")
    assert commit_of(root) == commit + "+"
    assert len(commit) == 40
