"""Loads of the links of a mesh in an exchange from each node to all, by XOR and by cyclic shifts."""

from itertools import pairwise

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.mesh_links import worst_link_loads


@pytest.mark.parametrize(("side", "order", "total", "most"), [
    (4, "xor", 27, 2), (4, "shift", 22, 2), (8, "xor", 219, 4), (8, "shift", 172, 4)])
def test_sums_over_the_steps_are_the_digest_s(side, order, total, most):
    loads = worst_link_loads(side, order)
    assert (len(loads), loads.sum(), loads.max()) == (side * side - 1, total, most)


@pytest.mark.parametrize("order", ["xor", "shift"])
def test_loads_are_those_of_routes_walked_link_by_link(order):
    side, loads = 4, []
    for step in range(1, 16):
        used = {}
        for node in range(16):
            y, x = divmod(node, side)
            to_y, to_x = divmod(node ^ step, side) if order == "xor" else (
                (y + step % side) % side, (x + step // side) % side)
            across = range(x, to_x + 1) if x <= to_x else range(x, to_x - 1, -1)
            along = range(y, to_y + 1) if y <= to_y else range(y, to_y - 1, -1)
            route = [(y, one) for one in across] + [(one, to_x) for one in along][1:]
            for link in pairwise(route):
                used[link] = used.get(link, 0) + 1
        loads.append(max(used.values()))
    assert np.array_equal(worst_link_loads(side, order), loads)


def test_wrong_meshes_are_refused():
    with pytest.raises(InputError, match="Order must be one of xor, shift, not 'snake'"):
        worst_link_loads(4, "snake")
    with pytest.raises(InputError, match="Side must be a power of two of at least 2, not 6"):
        worst_link_loads(6, "xor")
