import numpy as np
import pytest
from scipy import sparse

from golden.base.errors import InputError
from golden.light.solvers import SOLVERS, RadiositySystem
from tb.golden.light.solvers.systems import DUCT_FACTORS, DUCT_RADIOSITY, duct


class Rows:
    """Rows on demand that remembers which were requested."""

    def __init__(self, factors):
        self.factors, self.requested = factors, []

    def __call__(self, patches):
        self.requested.extend(patches.tolist())
        return sparse.csr_array(self.factors[patches])


@pytest.mark.parametrize("name", ["progressive", "overshooting", "proximity"])
def test_shooting_by_reciprocity_finds_the_same_solution(name):
    solution = SOLVERS[name](duct(Rows(DUCT_FACTORS)), tolerance=1e-9)
    np.testing.assert_allclose(solution.radiosity[:, 0], DUCT_RADIOSITY, rtol=0, atol=6e-9)


def test_shooting_requests_the_shooting_row_and_no_others():
    provider = Rows(DUCT_FACTORS)
    SOLVERS["progressive"](duct(provider), max_steps=2)
    assert provider.requested == [0]


def test_shooting_through_a_stored_matrix_needs_no_reciprocity():
    irregular = np.array([(0, 0.9, 0.1), (0.5, 0, 0.5), (0.1, 0.1, 0)])
    system = duct(irregular)
    solution = SOLVERS["progressive"](system, tolerance=1e-10)
    assert np.abs(system.residual(solution.radiosity)).max() < 1e-9


@pytest.mark.parametrize(("change", "message"), [
    ({"area": (3, 4, 0)}, "Area must be above 0"),
    ({"area": ((3, 4, 5),)}, "Area must be N, not"),
    ({"area": ()}, "Area must be above 0 for at least one patch"),
    ({"reflectance": np.full((3, 3), 1.1)}, "Reflectance must be 0 to 1"),
    ({"reflectance": np.zeros((3, 2))}, "Reflectance must be 3 x 3"),
    ({"emission": np.full((3, 3), -1.0)}, "Emission must be at least 0"),
    ({"emission": np.full((3, 3), np.inf)}, "Emission must be finite"),
    ({"form_factors": np.zeros((3, 2))}, "Form factors must be 3 x 3"),
    ({"form_factors": np.full((3, 3), np.nan)}, "Form factors must be finite"),
    ({"centre": np.zeros((2, 3))}, "Centre must be 3 x 3"),
])
def test_unusable_systems_are_refused(change, message):
    count = 0 if change.get("area") == () else 3
    given = {"form_factors": DUCT_FACTORS[:count, :count], "area": (3, 4, 5),
             "reflectance": np.zeros((count, 3)), "emission": np.zeros((count, 3))}
    with pytest.raises(InputError, match=message):
        RadiositySystem(**given | change)
