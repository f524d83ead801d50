"""What a ledger keeps, and what it says of a commit."""

import pytest

from tb.runs.ledger import Entry, Ledger


def entry(shard, result, inputs="i0"):
    return Entry(shard=shard, commit="c" * 40, inputs=inputs, reads="", seed=3, versions={"python": "3.11"},
                 began="2026-01-01T00:00:00", wall=90.0, cpu=150.0, passed=7, failed=int(result == "red"), skipped=0,
                 result=result)


def test_entries_are_read_again(tmp_path):
    path = tmp_path / "folder" / "ledger.jsonl"
    ledger = Ledger(path)
    ledger.add(entry("icu", "green"))
    ledger.add(entry("noc", "red"))
    assert Ledger(path).entries == ledger.entries == [entry("icu", "green"), entry("noc", "red")]


def test_a_shard_is_missing_until_its_newest_run_on_its_inputs_is_green(tmp_path):
    ledger = Ledger(tmp_path / "ledger.jsonl")
    names = ["axi", "icu", "lib", "noc", "ctu", "control"]
    ledger.add(entry("icu", "red"))
    ledger.add(entry("icu", "green"))
    ledger.add(entry("lib", "green"))
    ledger.add(entry("lib", "late"))
    ledger.add(entry("noc", "green", inputs="i1"))
    ledger.add(entry("ctu", "green", inputs=""))
    ledger.add(entry("control", "green"))
    assert ledger.missing(names, lambda shard, reads: "i0") == ["axi", "lib", "noc", "ctu"]
    assert ledger.missing(["ctu"], lambda shard, reads: "") == ["ctu"]


def test_the_table_has_a_row_for_each_shard(tmp_path):
    ledger = Ledger(tmp_path / "ledger.jsonl")
    ledger.add(entry("icu", "red"))
    assert ledger.table(["axi", "icu"], lambda shard, reads: "i0").splitlines()[2:] == [
        "| axi | - | - | - | - | - | - | - |", "| icu | red | 7 | 1 | 1.5 | 2.5 | 3 | cccccccccc |"]


@pytest.mark.parametrize("line", ["{", "[]", '{"shard": "icu"}'])
def test_what_is_no_entry_is_named_by_its_line(tmp_path, line):
    path = tmp_path / "ledger.jsonl"
    Ledger(path).add(entry("icu", "green"))
    path.write_text(path.read_text() + line + "\n")
    with pytest.raises(ValueError, match=r"ledger\.jsonl, line 2: no entry"):
        Ledger(path)
