import pytest

from benchmarks.daylight_cases import CASES

# One of each kind; `make nightly` measures the others.
QUICK = ("roof, uniform sky", "pane in the facade, cie-overcast sky", "lamps", "luminaire")


@pytest.mark.parametrize("name", [pytest.param(name, marks=[] if name in QUICK else pytest.mark.nightly)
                                  for name in CASES])
def test_illuminances_are_within_a_hundredth_of_the_truth(name):
    cases = list(CASES[name]())
    assert cases
    for case in cases:
        assert abs(case.error) < 0.01, case
