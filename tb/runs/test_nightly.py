"""How shards end, and what the ledger then says."""

import hashlib
import os
import signal
import subprocess
import sys

import pytest

from tb.runs.checkout import checkout
from tb.runs.inputs import Inputs, commit_of
from tb.runs.ledger import Ledger
from tb.runs.nightly import begin, counts, end, run_shards
from tb.runs.shard import Shard

PASSES = "import os\n\n\ndef test_seed():\n    assert os.environ['SEED'] == '5'\n"
FILES = {
    "tb/a/test_green.py": PASSES, "tb/b/test_red.py": PASSES + "\n\ndef test_wrong():\n    assert 0\n",
    "tb/c/test_skips.py": PASSES + "\n\ndef test_left():\n    import pytest\n    pytest.skip('no')\n",
    "tb/d/test_broken.py": "import nothing_of_this_name\n",
}


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A project, and its ledger after all shards ran."""
    folder = tmp_path_factory.mktemp("runs")
    root = checkout(folder / "project", FILES)
    ledger, seen = Ledger(folder / "ledger.jsonl"), []
    shards = [Shard(name.split("/")[1], (root / name,)) for name in FILES]
    is_green = run_shards(root, shards, ledger, seed=5, report=seen.append, processes=0)
    assert seen == ledger.entries
    assert not is_green
    return root, {entry.shard: entry for entry in ledger.entries}


def test_a_shard_is_green_if_all_of_its_tests_passed(ran):
    found = {name: (entry.result, entry.passed, entry.failed, entry.skipped) for name, entry in ran[1].items()}
    assert found == {"a": ("green", 1, 0, 0), "b": ("red", 1, 1, 0), "c": ("red", 1, 0, 1), "d": ("red", 0, 1, 0)}


def test_an_entry_names_commit_seed_and_tools(ran):
    root, entries = ran
    assert {entry.commit for entry in entries.values()} == {commit_of(root)}
    shards = [Shard(name.split("/")[1], (root / name,)) for name in FILES]
    inputs = Inputs(root, shards)
    assert all(entry.inputs == inputs.digest(entry.shard, entry.reads) for entry in entries.values())
    # Each shard opens its test module alone.
    assert {name: entry.reads for name, entry in entries.items()} == {
        file.split("/")[1]: hashlib.sha256(file.encode()).hexdigest()[:4] for file in FILES}
    assert {entry.seed for entry in entries.values()} == {5}
    assert all({"python", "verilator", "icarus", "amaranth"} <= set(entry.versions) for entry in entries.values())
    assert all(entry.cpu > 0 for entry in entries.values())


def test_a_shard_that_takes_too_long_is_ended(tmp_path):
    root = checkout(tmp_path / "project", {"tb/a/test_it.py": "import time\n\ntime.sleep(9999)\n"})
    ledger, shard = Ledger(tmp_path / "ledger.jsonl"), Shard("a", (root / "tb/a/test_it.py",))
    assert not run_shards(root, [shard], ledger, seed=1, report=str, most=0, processes=0)
    assert [entry.result for entry in ledger.entries] == ["late"]


def test_a_shard_that_is_ended_reports_what_ended_before(tmp_path):
    """Red tests of a late shard have names; in the background too, where interrupts are ignored."""
    tests = "def test_wrong():\n    assert 0\n\n\ndef test_right():\n    pass\n\n\ndef test_slow():\n    import time\n"
    root = checkout(tmp_path / "project", {"tb/a/test_it.py": f"{tests}    time.sleep(9999)\n"})
    command = [sys.executable, "-m", "pytest", "-q", "-n", "2", "--dist", "loadfile", "--junitxml=report.xml", "tb/a"]
    ignored = signal.signal(signal.SIGINT, signal.SIG_IGN)
    with begin(command, root, os.environ, stdout=subprocess.PIPE, text=True) as process:
        signal.signal(signal.SIGINT, ignored)
        # A test is in the report before the next is printed.
        seen = ""
        while not seen.endswith("F.") and (letter := process.stdout.read(1)):
            seen += letter
        end(process)
    assert counts(root / "report.xml")[1] == 1
    assert "test_wrong" in (root / "report.xml").read_text()


def test_no_shard_begins_after_the_minutes(tmp_path):
    root = checkout(tmp_path / "project", {})
    ledger = Ledger(tmp_path / "ledger.jsonl")
    assert not run_shards(root, [Shard("a", ())], ledger, seed=1, report=str, minutes=-1)
    assert not ledger.entries


def test_no_report_counts_nothing(tmp_path):
    assert counts(tmp_path / "report.xml") == (0, 0, 0)
