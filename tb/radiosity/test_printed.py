"""What every command prints and writes stays what it is: texts, members of JSON objects, exit codes, files.

The record is of small inputs, so that each command with most of its options takes a part of a second.
"""

import json

import pytest

from tb.radiosity.printed import RECORD, listed, results

# Simulated machines are compiled once, for all tests of this group.
pytestmark = pytest.mark.xdist_group("machines")
RECORDED = {" ; ".join(row["commands"]): row for row in json.loads(RECORD.read_text())}


@pytest.mark.parametrize("commands", RECORDED)
def test_a_command_prints_and_writes_what_it_did(commands):
    row = RECORDED[commands]
    for command, found, expected in zip(row["commands"], results(row["commands"]), row["results"], strict=True):
        assert found == expected, f"radiosity {command}"


def test_a_record_does_not_depend_on_the_digits_of_seconds():
    assert listed("seconds      0.95\n  image      9.87\n") == listed("seconds     10.95\n  image    123.45\n") == [
        "seconds      #", "  image      #"]
