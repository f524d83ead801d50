"""The verification report as the site has it, from a process of its own, of a few tests."""

import re

import pytest

from tb.docs.verification import report

# `make docs`, which a commit runs too, collects all tests.
pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def text():
    return report("tb/formal/lib/test_queue.py", "tb/formal/lib/test_fork.py")


def test_proofs_are_listed_with_their_negative_controls(text):
    assert "### queue" in text
    assert "Order and count" in text
    assert "| holds | queue: depth=1; queue: depth=2;" in text
    assert "| can be reached | queue: depth=1;" in text
    assert "| must fail | queue: is ready when full; queue: delivers an item twice" in text
    assert "queue: another depth" in text


def test_tests_are_counted_and_cases_named(text):
    def counts(name):
        return [int(count or 0) for count in re.search(rf"^\| {name} \| ?(.*) \|$", text, re.MULTILINE)[1].split(" | ")]

    files, *folder = counts("`tb/formal/lib`")
    queue, fork = counts("`test_queue.py`"), counts("`test_fork.py`")
    assert files == 2
    assert folder == [sum(both) for both in zip(queue, fork, strict=True)] == counts("all")[1:]
    # Of each proof at least one that holds, one that is reached and one that must fail.
    assert min(sum(queue), sum(fork)) >= 3
    assert "equally near with a smaller id" in text
