"""A commit is tagged if everything passed, and only then."""

import subprocess

import pytest

from tb.runs.checkout import checkout
from tb.runs.inputs import Inputs
from tb.runs.ledger import Entry, Ledger
from tb.runs.release import NotReadyError, release
from tb.runs.shard import shards

FILES = {"pyproject.toml": '[project]\nversion = "0.2.0"\n', "tb/a/test_it.py": "", "tb/b/test_it.py": "",
         "CHANGELOG.md": "# Changelog\n\n## [0.2.0] - 2026-01-01\n\n- New.\n\n## [0.1.0]\n\n- Old.\n"}
PASSES = {"test": ["sh", "-c", "ls; echo 3 passed"]}


def green(root, ledger, *names):
    inputs = Inputs(root, shards(root / "tb"))
    for name in names:
        ledger.add(Entry(shard=name, commit="c" * 40, inputs=inputs.digest(name, ""), reads="", seed=1, versions={},
                         began="", wall=60, cpu=60, passed=1, failed=0, skipped=0, result="green"))


@pytest.fixture
def project(tmp_path):
    root = checkout(tmp_path / "project", FILES)
    return root, Ledger(tmp_path / "ledger.jsonl")


def tags(root):
    return subprocess.run(["git", "tag", "-n99"], cwd=root, capture_output=True, text=True, check=True).stdout


def test_what_passed_is_tagged_with_its_notes(project):
    root, ledger = project
    green(root, ledger, "a", "b")
    said = []
    assert release(root, ledger, report=said.append, steps=PASSES) == "v0.2.0"
    notes = tags(root)
    assert "- New." in notes
    assert "- Old." not in notes
    assert "test: 3 passed" in notes
    assert "| b | green | 1 | 0 | 1.0 | 1.0 | 1 | cccccccccc |" in notes
    assert said == ["== sh -c ls; echo 3 passed"]


def test_steps_run_in_a_clean_clone(project):
    root, ledger = project
    (root / "out").mkdir()
    (root / "out" / "left").touch()
    green(root, ledger, "a", "b")
    release(root, ledger, report=str, steps={"test": ["sh", "-c", "test -e CHANGELOG.md && test ! -e out"]})
    assert "v0.2.0" in tags(root)


@pytest.mark.parametrize(("spoil", "why"), [
    (lambda root, ledger: (root / "new").touch(), "files differ"),
    (lambda root, ledger: subprocess.run(["git", "tag", "v0.2.0"], cwd=root, check=True), "tag v0.2.0 exists"),
    (lambda root, ledger: subprocess.run("echo >> pyproject.toml; git commit -qam More", shell=True, cwd=root,
                                         check=True), "not green in the ledger for .*: a, b"),
    (lambda root, ledger: subprocess.run("echo >> tb/a/test_it.py; git commit -qam More", shell=True, cwd=root,
                                         check=True), "not green in the ledger for .*: a$"),
], ids=["changed", "tagged", "another commit", "other tests"])
def test_what_is_not_ready_is_not_tagged(project, spoil, why):
    root, ledger = project
    green(root, ledger, "a", "b")
    spoil(root, ledger)
    with pytest.raises(NotReadyError, match=why):
        release(root, ledger, report=str, steps=PASSES)
    assert "New." not in tags(root)


def test_a_missing_shard_is_named(project):
    root, ledger = project
    green(root, ledger, "a")
    with pytest.raises(NotReadyError, match=r": b$"):
        release(root, ledger, report=str, steps=PASSES)


def test_a_version_without_notes_is_refused(tmp_path):
    root = checkout(tmp_path / "project", {**FILES, "CHANGELOG.md": "## [0.1.0]\n"})
    with pytest.raises(NotReadyError, match=r"CHANGELOG.md has no entry for 0\.2\.0"):
        release(root, Ledger(tmp_path / "ledger.jsonl"), report=str, steps=PASSES)


def test_a_step_that_fails_is_named_with_its_log(project):
    root, ledger = project
    green(root, ledger, "a", "b")
    with pytest.raises(NotReadyError, match=r"sh -c exit 1 failed; .*release-sim\.txt"):
        release(root, ledger, report=str, steps={**PASSES, "sim": ["sh", "-c", "exit 1"]})
    assert not tags(root)
