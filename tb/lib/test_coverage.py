import numpy as np
import pytest

from tb.lib.coverage import Coverage


def test_what_never_occurred_is_named():
    coverage = Coverage(["empty", "full", "wrapped"])
    coverage.hit("full")
    with pytest.raises(AssertionError, match=r"^2 of 3 cases never occurred: empty, wrapped$"):
        coverage.check()
    coverage.hit("empty")
    coverage.hit("wrapped", False)
    assert coverage.missing == ["wrapped"]
    with pytest.raises(AssertionError, match=r"^1 of 3 cases never occurred: wrapped$"):
        coverage.check()
    coverage.hit("wrapped")
    coverage.check()


def test_arrays_count_as_often_as_they_are_true():
    coverage = Coverage(["odd", "even", "large"])
    numbers = np.arange(7)
    coverage.hit_all({"odd": numbers % 2 == 1, "even": numbers % 2 == 0, "large": numbers > 9})
    assert coverage.counts == {"odd": 3, "even": 4, "large": 0}
    assert coverage.missing == ["large"]
    assert coverage.has(["odd", "even"])
    assert not coverage.has(["odd", "large"])


def test_an_unnamed_case():
    with pytest.raises(KeyError, match="there is no case 'ful'; there are full, empty"):
        Coverage(["full", "empty"]).hit("ful")


@pytest.mark.parametrize("cases", [[], ["full", "full"]])
def test_init_wrong_cases(cases):
    with pytest.raises(ValueError, match=r"^Cases must be at least one, each with a name of its own, not \["):
        Coverage(cases)
