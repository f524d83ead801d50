"""Every test can fail: no assertion is true whatever happens, and no test is without one."""

import pytest

from tb.sources.assertions import Assertions, idle_assertions
from tb.sources.source_texts import source_texts

# Whose texts are examples.
OWN = "tb/sources/test_assertions.py"
# Tests that fail by an exception of what they call.
EXCEPTIONS = {"tb/lib/test_validate.py: test_an_integer_of_the_range_passes asserts nothing",
              "tb/lib/test_validate.py: test_a_power_of_two_passes asserts nothing"}


def test_assertions_can_fail():
    found = [f"{path}:{line}: {why}" for path, text in source_texts("tb").items() if path != OWN
             for line, why in idle_assertions(text)]
    assert not found, "\n".join(found)


def test_tests_assert():
    texts = source_texts("tb")
    assertions = Assertions(texts)
    assert {f"{path}: {why}" for path in texts for _, why in assertions.without(path)} == EXCEPTIONS


@pytest.mark.parametrize(("text", "why"), [
    ("assert a == a", "itself"), ("assert a.b[0] <= a.b[0]", "itself"), ("assert 0 < a < a", "itself"),
    ("b = [one for one in c if one != one]", "itself"), ("assert True", "true"), ("assert 'a'", "true"),
    ("assert not False", "true"), ("assert (x for x in a)", "true"), ("assert lambda: a", "true"),
    ("assert len(a) >= 0", "true"), ("assert len(a) > -1", "true"),
    ("try:\n    a()\nexcept ValueError:\n    pass", "exception"), ("try:\n    a()\nexcept:\n    ...", "exception"),
    ("def a():\n    def b():\n        assert c\n    d()", "b is never called")])
def test_idle_assertions_are_found(text, why):
    ((_, found),) = idle_assertions(text)
    assert why in found


@pytest.mark.parametrize("text", [
    "assert a == b", "assert f(a) == f(a)", "assert next(a) < next(a)", "assert a.b == b", "assert a == a + b",
    "assert b - a == a", "assert a == a[1:]", "assert a[0] == a[1]", "assert a", "assert not a", "assert False",
    "assert len(a) >= 1", "assert [x for x in a]", "try:\n    a()\nexcept ValueError as b:\n    c = b",
    "def a():\n    def b():\n        assert c\n    b()", "def a():\n    @given(c)\n    def b():\n        assert c"])
def test_assertions_that_can_fail_pass(text):
    assert list(idle_assertions(text)) == []


HELPERS = """
class Bench:
    def __init__(self, dut):
        assert dut
    def check(self, a):
        self._check(a)
    def _check(self, a):
        raise Wrong(a)
    def step(self):
        raise ValueError
class Wrong(AssertionError):
    pass
def compare(a, b):
    return equal(a, b)
def equal(a, b):
    assert a == b
def run(a):
    a.step()
"""
IMPORTS = "from tb.parts import Bench, compare, run"
FUNCTIONS = """
def own(a):
    assert a
def other(a):
    a()
"""


@pytest.mark.parametrize(("body", "asserts"), [
    ("assert a", True), ("compare(a, b)", True), ("own(a)", True), ("bench.check(a)", True), ("Bench(a)", True),
    ("with pytest.raises(ValueError):\n        a()", True), ("pytest.fail('a')", True), ("parts.equal(a, b)", True),
    ("np.testing.assert_array_equal(a, b)", True), ("raise AssertionError(a)", True),
    ("a == b", False), ("run(a)", False), ("bench.step()", False), ("other(a)", False), ("raise ValueError", False)])
@pytest.mark.parametrize("head", ["def test_a(a, b):", "@cocotb.test()\nasync def latency(dut):"])
def test_tests_without_an_assertion_are_found(head, body, asserts):
    text = f"{IMPORTS}\n{head}\n    {body}\n{FUNCTIONS}"
    assertions = Assertions({"tb/parts.py": HELPERS, "tb/test_a.py": text})
    found = [why for _, why in assertions.without("tb/test_a.py")]
    assert [why.partition(" ")[2] for why in found] == ([] if asserts else ["asserts nothing"])
