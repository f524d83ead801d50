"""Small scenes and machines for nodes that pass rays."""

from functools import cache

import numpy as np

from radiosity.machines.torus.torus_run import TorusSetup, simulate_torus
from radiosity.machines.torus.torus_scene import TorusScene

__all__ = ["SIZE", "drawn_scene", "run_small"]

# Rows and columns of pixels.
SIZE = 12, 10


def drawn_scene(seed, *, spheres=6, polygons=14, glass=0.0):
    """Drawn spheres, triangles and quadrilaterals, all of which mirror a little, and two lights."""
    rng = np.random.default_rng(seed)
    corners = np.zeros((spheres + polygons, 4, 3))
    corners[:spheres, 0] = rng.uniform((-1, -1, 3), (1, 1, 5), (spheres, 3))
    corners[:spheres, 1, 0] = rng.uniform(0.1, 0.4, spheres)
    centre, one, two = (rng.uniform(-1, 1, (polygons, 3)) for _ in range(3))
    centre[:, 2] += 4
    one, two = one / 2, two / 2
    corners[spheres:] = np.stack([centre, centre + one, centre + one + two, centre + two], axis=1)
    counts = np.append(np.zeros(spheres, dtype=np.int64), np.full(polygons, 4))
    counts[spheres::3] = np.where(counts[spheres::3] == 4, 3, 0)
    corners[counts == 3, 3] = corners[counts == 3, 2]
    coefficients = np.concatenate([
        rng.uniform(0, 0.1, (len(counts), 3)), rng.uniform(0.1, 0.5, (len(counts), 3)),
        rng.uniform(0, 0.4, (len(counts), 3)), np.full((len(counts), 3), glass), np.full((len(counts), 1), 1.5)],
        axis=1)
    lights = [[-3, 4, 0, 0.2, 0.6, 0.5, 0.4], [0.2, 0.3, 3.4, 0.05, 0.3, 0.4, 0.5]]
    return TorusScene(name="drawn", corners=corners, counts=counts, coefficients=coefficients,
                      lights=np.array(lights), slope=0.35)


@cache
def run_small(drawn=1, *, glass=0.0, log=0, **changes):
    """A small picture of a drawn scene; the same one again for the same machine."""
    setup = {"nodes": 4, "size": SIZE, "subdivisions": 5, **changes}
    return simulate_torus(drawn_scene(drawn, glass=glass), TorusSetup(**setup), log=log)
