import numpy as np
import pytest
from scipy import sparse

from golden.base.errors import InputError
from golden.light.solvers import RadiositySystem
from golden.light.solvers.on_demand import Shooting, shoot
from tb.golden.light.solvers.systems import exact, lit_cube


class Rows:
    """Rows on demand of a system, and which were requested together."""

    def __init__(self, system):
        self._system, self.requested = system, []

    def __call__(self, ids):
        self.requested.append(ids.tolist())
        return sparse.csr_array(self._system.matrix[ids])

    @property
    def patches(self):
        """Those whose rows were requested."""
        return {patch for step in self.requested for patch in step}


def on_demand():
    system = lit_cube("analytic")
    rows = Rows(system)
    return rows, RadiositySystem(form_factors=rows, reflectance=system.reflectance, emission=system.emission,
                                 area=system.area, centre=system.centre, normal=system.normal)


@pytest.mark.parametrize("overshoot", [False, True])
@pytest.mark.parametrize("shooters", [1, 6])
def test_less_light_is_missing_than_the_tolerance(shooters, overshoot):
    """In a closed room of one reflectance light that met all patches evenly would add what the estimate says."""
    rows, system = on_demand()
    found = shoot(system, Shooting(tolerance=0.02, shooters=shooters, overshoot=overshoot))
    truth = exact(lit_cube("analytic"))
    missing = np.sqrt((system.area[:, None] * (found.display - truth) ** 2).sum(axis=0))
    assert found.converged
    assert (missing <= 0.02 * np.sqrt((system.area[:, None] * truth**2).sum(axis=0))).all()
    assert len(rows.patches) >= 64


def test_the_rows_of_a_step_are_requested_together():
    rows, system = on_demand()
    shoot(system, Shooting(tolerance=0.001, shooters=6))
    assert max(map(len, rows.requested)) == 6


def test_only_what_shines_is_cast_for_the_first_light():
    """The lamp is a face of six: 64 of 384 patches, and nothing else has light to shoot before they have."""
    rows, system = on_demand()
    states = []
    shoot(system, Shooting(tolerance=0.3, shooters=4, overshoot=False), watch=states.append)
    assert len(rows.patches) <= 64
    assert len(states) == len(rows.requested) + 1
    assert all((system.emission[patch] > 0).all() for step in rows.requested for patch in step)


@pytest.mark.parametrize("given", [
    {"tolerance": 0}, {"tolerance": 0.6}, {"tolerance": True}, {"tolerance": "1"}, {"shooters": 0}, {"shooters": 5000},
    {"shooters": 1.5}, {"shooters": True}, {"overshoot": 1}])
def test_what_is_out_of_range_is_named(given):
    with pytest.raises(InputError, match=next(iter(given)).capitalize()):
        Shooting(**given)
