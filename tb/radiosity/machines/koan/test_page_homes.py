"""The home of a page serves its requests, and no other node."""

import numpy as np
import pytest

from tb.radiosity.machines.koan.programs import QUICK, run_programs


@pytest.mark.parametrize(("nodes", "page"), [(4, 0), (4, 5), (8, 21)])
def test_a_request_interrupts_the_home_alone(nodes, page):
    home = page % nodes
    programs = [[(10_000_000, [])] for _ in range(nodes)]
    programs[(home + 2) % nodes] = [(0, [(page, 0, 0, 0)])]
    found = run_programs(programs, pages=24)
    assert np.flatnonzero(found.counts["interrupted"]).tolist() == [home]
    assert found.counts["interrupted"][home] == QUICK.serve + QUICK.setup
