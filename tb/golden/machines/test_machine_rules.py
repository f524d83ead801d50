"""Each numbered rule of the machines' sources has tests, or the reason for which it is not built."""

import csv
import re
import tomllib

import pytest

from tb.sources.source_trees import ROOT

RECORDS = ROOT / "docs" / "records"
RULES = tomllib.loads((RECORDS / "machine-rules.toml").read_text())
# Of each list, the letter of its numbers, how many digits they have, and the last one.
LISTS = {"M": (2, 58), "K": (1, 20), "R": (2, 22), "P": (2, 14), "V": (2, 14)}


def built():
    return {rule["id"]: rule["tests"] for rule in RULES["rule"] if "tests" in rule}


def test_every_number_of_the_lists_is_there_once():
    numbers = [f"{letter}{number:0{digits}d}" for letter, (digits, last) in LISTS.items()
               for number in range(1, last + 1)]
    assert [rule["id"] for rule in RULES["rule"]] == numbers


@pytest.mark.parametrize("rule", RULES["rule"], ids=lambda rule: rule["id"])
def test_a_rule_has_tests_that_exist_or_a_reason(rule):
    assert set(rule) in ({"id", "machine", "is", "tests"}, {"id", "machine", "is", "not_built"})
    assert rule["is"]
    assert rule.get("tests", rule.get("not_built"))
    for test in rule.get("tests", []):
        file, _, name = test.partition("::")
        assert re.search(rf"^def {name}\(", (ROOT / file).read_text(), re.MULTILINE), test


@pytest.mark.parametrize("bug", RULES["bug"], ids=lambda bug: bug["id"])
def test_the_text_that_a_bug_replaces_occurs_once(bug):
    """Where it has changed or come twice, the bug can no longer be injected."""
    assert (ROOT / bug["file"]).read_text().count(bug["old"]) == 1
    assert bug["new"] != bug["old"]


def test_each_rule_that_is_built_has_a_bug_that_one_of_its_tests_has_noticed():
    rows = csv.DictReader((RECORDS / "machine-rules.csv").read_text().splitlines())
    noticed = {row["bug"]: row["killed_by"] for row in rows}
    assert list(noticed) == [bug["id"] for bug in RULES["bug"]]
    assert {number.partition("-")[0] for number in noticed} == set(built())
    for number, test in noticed.items():
        assert test.partition("[")[0] in built()[number.partition("-")[0]], number
