"""Counts with their noun."""

import pytest

from golden.base.plural import counted


@pytest.mark.parametrize(("count", "noun", "text"), [
    (0, "cell", "0 cells"), (1, "patch", "1 patch"), (2, "patch", "2 patches"), (3, "grid ray", "3 grid rays")])
def test_a_noun_agrees_with_its_count(count, noun, text):
    assert counted(count, noun) == text
