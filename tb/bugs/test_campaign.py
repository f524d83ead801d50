"""A draw: its folders, the tests near each bug, what kills it, and what a second call still does."""

import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

import tb.bugs.tree
from golden.base.errors import InputError
from tb.bugs.campaign import Campaign
from tb.bugs.drawing import LEAST, candidates, strata
from tb.bugs.nearness import change_detectors, commit_marks, folder_tests, near_tests, simulated, simulator_marks
from tb.bugs.table import page, read_equivalent
from tb.bugs.tree import Outcome, Tree, cpu_seconds
from tb.runs.checkout import checkout

FILES = {
    "golden/sums.py": "def total(a, b, scale=1):\n    return (a + b) * scale\n",
    "hw/icu/unit.py": "from golden.sums import total\n\n\ndef twice(a, most=9):\n    return min(total(a, a), most)\n",
    "tb/golden/test_sums.py": "from golden.sums import total\n\n\ndef test_total():\n    assert total(3, 1) == 4\n",
    "tb/golden/test_record.py": 'FILE = "record.json"\n\n\ndef test_record():\n    assert FILE\n',
    "tb/golden/record.json": "{}",
    "tb/icu/test_unit.py": "from hw.icu import unit\n\n\ndef test_twice():\n    assert unit.twice(2) == 4\n",
    "tb/icu/test_pair.py": "from hw.icu.unit import twice\n\n\ndef test_pair():\n"
                           "    while twice(3) == 8:\n        pass\n",
    "tb/bugs/elaboration.py": "import hw.icu.unit\n",
    "tb/system/test_machine.py": "def test_machine():\n    assert True\n",
    "tb/docs/test_pages.py": "from golden.sums import total\n\n\ndef test_page():\n    assert total\n",
    "tb/system/test_texts.py": "import ast\n\n\ndef test_names():\n    assert ast.parse('')\n\n\n"
                               "def test_one():\n    assert 1\n",
    "Makefile": 'BLOCKS  := icu noc\ntest: lint ## fast\n\tpytest -n 2 -m "not nightly and not sim"\n\nsim: ## slow\n'
                '\t@echo sim\n\tpytest -n 2 -m "not nightly" $(BENCHES)\n',
    "pytest.ini": "[pytest]\nmarkers =\n    nightly\n    sim\n"}
LINES = {path: text.count("\n") for path, text in FILES.items() if path.startswith(("golden", "hw"))}


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """A small project in a repository."""
    return checkout(tmp_path_factory.mktemp("project") / "root", FILES)


def test_folders_have_bugs_by_lines_and_a_longer_draw_goes_on():
    files = {"golden/light/a.py": 500, "golden/light/factors/b.py": 440, "hw/icu/c.py": 59, "hw/noc/d.py": 1}
    drawn = strata(files, 1000, "seed")
    assert strata(files, 10, "seed") == drawn[:10]
    assert strata(files, 1000, "other") != drawn
    counts, shares = Counter(drawn), {"golden/light": 0.94, "hw/icu": 0.059, "hw/noc": LEAST}
    assert all(abs(counts[name] - 1000 * share / sum(shares.values())) <= 1 for name, share in shares.items())


def test_odd_bugs_have_a_condition_and_all_replay(root):
    for number in 0, 1, 2, 3:
        first, again, other = (next(candidates(root, LINES, "golden", number, seed)) for seed in ("a", "a", "b"))
        assert first == again
        assert bool(first.guard) == bool(number % 2) == bool(other.guard)
        assert first.text != FILES["golden/sums.py"]


def test_a_digest_is_of_one_bug_of_one_function(root, tmp_path):
    bugs = {bug.digest: bug for bug, _ in zip(candidates(root, LINES, "golden", 0, "a"), range(30), strict=False)}
    assert len(bugs) == len({bug.text for bug in bugs.values()}) > 3
    (tmp_path / "golden").mkdir()
    (tmp_path / "golden/sums.py").write_text("SIZE = 3\n\n\n" + FILES["golden/sums.py"])
    moved = {bug.digest for bug, _ in zip(candidates(tmp_path, LINES, "golden", 0, "a"), range(30), strict=False)}
    assert bugs.keys() <= moved
    (tmp_path / "golden/sums.py").write_text(FILES["golden/sums.py"].replace("return", "return 0 +"))
    changed = {bug.digest for bug, _ in zip(candidates(tmp_path, LINES, "golden", 0, "a"), range(30), strict=False)}
    assert not bugs.keys() & changed


def test_tests_near_a_file(root):
    assert change_detectors(root) == {"tb/golden/test_record.py", "tb/docs/test_pages.py",
                                      "tb/system/test_texts.py::test_names"}
    assert near_tests("golden/sums.py", root) == ["tb/golden/test_sums.py"]
    assert near_tests("hw/icu/unit.py", root) == ["tb/icu/test_unit.py", "tb/icu/test_pair.py"]
    assert folder_tests("hw/icu/unit.py", root) == folder_tests("hw/icu/parts/a.py", root) == ["tb/icu"]
    assert folder_tests("hw/engine.py", root) == ["tb/system"]
    assert simulated(root) == ["tb/icu", "tb/noc"]
    assert commit_marks(root) == "not nightly and not sim"
    assert simulator_marks(root) == "(not nightly) and not (not nightly and not sim)"


def test_a_tree_runs_tests_with_a_bug_and_without(root, tmp_path, monkeypatch):
    monkeypatch.chdir(root)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    tree = Tree(tmp_path / "tree", "HEAD")
    bugs = {bug.text: bug for bug, _ in zip(candidates(root, LINES, "hw/icu", 0, "a"), range(40), strict=False)}
    bug = next(bug for text, bug in bugs.items() if "total(a, a), most" in text and "max(" in text)
    assert tree.fault(bug) == ""
    tree.inject(bug)
    done = tree.run(["tb"], marks=commit_marks(root), limit=30, most=9, without=("tb/docs/test_pages.py",))
    assert (done.failed, done.ended) == (("tb/icu/test_unit.py::test_twice",), True)
    assert 0 < done.seconds < 30
    # One that has no end, one that cannot be imported, and the clean file.
    (tree.path / "hw/icu/unit.py").write_text("def twice(a):\n    return 8\n")
    log = tree.path / "build/bugs.log"
    monkeypatch.setattr(tb.bugs.tree, "cpu_seconds", lambda session: 31 * ("::test_pair" in log.read_text()))
    done = tree.run(["tb/icu/test_pair.py"], limit=30)
    assert done == Outcome(("tb/icu/test_pair.py::test_pair",), 31, False)
    (tree.path / "hw/icu/unit.py").write_text("def twice(a):\n    return missing\n")
    assert tree.fault(bug).startswith("lint: ")
    tree.inject()
    assert (tree.path / "hw/icu/unit.py").read_text() == FILES["hw/icu/unit.py"]
    with pytest.raises(InputError, match="pytest ends with 4"):
        tree.run(["tb/missing.py"], limit=30)


def test_seconds_are_those_of_a_session():
    with subprocess.Popen([sys.executable, "-c", "sum(range(3_000_000)); print(); input()"], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, start_new_session=True) as process:
        process.stdout.readline()
        assert cpu_seconds(process.pid) > 0
        process.communicate(b"\n")
    assert cpu_seconds(process.pid) == 0


class ScriptedTree:
    """Tests fail by a table: of a bug's number the stages' tests that it fails in."""

    def __init__(self, path, fails, *, clean=()):
        self.path, self._fails, self._clean = path, fails, set(clean)
        self.bugs, self.runs = (), []

    def inject(self, *bugs):
        """Remember bugs."""
        self.bugs = bugs

    def fault(self, bug):
        """Bugs of one rule do not count."""
        return "lint" if bug.rule == "constants" else ""

    def run(self, tests, *, marks="", limit, most=1, without=()):
        """Failures of what runs."""
        if not self.bugs and any(test.endswith("[drawn]") for test in tests):
            raise InputError("pytest ends with 4")
        self.runs.append(tuple(bug.number for bug in self.bugs))
        failing = self._clean | {test for bug in self.bugs for test in self._fails.get(bug.number, ())}
        found = [test for test in sorted(failing)
                 if test.startswith(tuple(tests)) and not test.startswith(tuple(without))]
        return Outcome(tuple(found[:most]), 2.0, True)


def run(root, record, fails, upto="detectors", **given):
    tree = ScriptedTree(root, fails, **given)
    campaign = Campaign(tree, record, seed="a", count=8, tell=lambda line: None)
    campaign.run(upto)
    return campaign.results, tree


def test_each_bug_meets_stages_until_it_is_killed(root, tmp_path):
    near = {0: ["tb/golden/test_sums.py::a[drawn]", "tb/icu/test_unit.py::a[drawn]"],
            1: ["tb/system/test_machine.py::a"], 2: ["tb/docs/test_pages.py::a"]}
    found, tree = run(root, tmp_path / "r.jsonl", near)
    assert [found[number].get("stage") for number in range(8)] == ["near", "commit", "detectors", *[None] * 5]
    assert all(one["rule"] != "constants" for one in found.values())
    assert any(one["refused"] for one in found.values())
    # Survivors are together in a run, but for those of the same file.
    assert max(map(len, tree.runs)) == 2
    assert run(root, tmp_path / "r.jsonl", near)[1].runs == []


def test_what_was_stopped_goes_on(root, tmp_path):
    fails = {1: ["tb/system/test_machine.py::a"]}
    found, before = run(root, tmp_path / "r.jsonl", fails, upto="folder")
    assert all("stage" not in one for one in found.values())
    found, after = run(root, tmp_path / "r.jsonl", fails)
    assert found[1]["stage"] == "commit"
    assert len(before.runs) + len(after.runs) == len(run(root, tmp_path / "s.jsonl", fails)[1].runs)


def test_tests_that_fail_without_a_bug_kill_none(root, tmp_path):
    bad = ["tb/golden/test_sums.py::bad", "tb/icu/test_unit.py::bad", "tb/system/test_machine.py::bad"]
    found, _ = run(root, tmp_path / "r.jsonl", {3: ["tb/system/test_machine.py::good"]}, clean=bad)
    assert [number for number, one in found.items() if "killer" in one] == [3]
    assert found[3]["killer"] == "tb/system/test_machine.py::good"


def test_the_table_counts_equivalent_bugs_apart(root, tmp_path):
    found, _ = run(root, tmp_path / "r.jsonl", {0: ["tb/golden/test_sums.py::a", "tb/icu/test_unit.py::a"]})
    same = sum(one["digest"] == found[2]["digest"] for one in found.values())
    text = page(found, {found[2]["digest"]: "the sum is never read"})
    assert f"| all | 8 | 1 | 0 | 0 | 0 | {7 - same} | {same} | {1 / (8 - same):.0%} |" in text
    assert text.count("```diff") == 7 - same
    assert found[2]["digest"] not in text


def test_lines_of_equivalent_bugs():
    assert read_equivalent("# why\n\nabc because of this\n") == {"abc": "because of this"}
    for text in "abc\n", "abc x\nabc y\n":
        with pytest.raises(ValueError, match="each once, not 'abc"):
            read_equivalent(text)


def test_the_project_has_its_change_detectors():
    """The rule finds the records that a command writes, and leaves testbenches out."""
    found = change_detectors(Path(__file__).parents[2])
    assert "tb/sources/test_functions.py" in found
    assert not {"tb/icu/test_sbb.py", "tb/golden/light/test_glass.py", "tb/system/test_engine.py"} & found
