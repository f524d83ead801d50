"""Each colour channel is a system of its own with the same form factors."""

import numpy as np
import pytest

from golden.light.solvers import gauss_jacobi
from radiosity.machines.gather.gather_run import simulate_gather
from radiosity.machines.gather.row_phase import GatherScheme
from tb.radiosity.machines.gather.nodes import room

pytestmark = pytest.mark.usefixtures("interpreted")


def test_channels_have_their_own_reflectances_and_emissions():
    _, system, work = room(40)
    coloured = type(system)(form_factors=system.matrix, area=system.area, reflectance=system.reflectance * (1, 0.5, 0),
                            emission=system.emission * (1, 2, 3))
    found = simulate_gather(coloured, work, GatherScheme(), nodes=4)
    # Both end at the same share of the largest radiosity.
    assert found.radiosity == pytest.approx(gauss_jacobi(coloured).radiosity, abs=1e-5 * coloured.emission.max())
    # Without reflection, patches have their emission; with more, the iterations are more.
    assert np.array_equal(found.radiosity[:, 2], coloured.emission[:, 2])
    assert found.channels[0].iterations > found.channels[1].iterations > found.channels[2].iterations
