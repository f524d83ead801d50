"""Small scenes, projections and matrices for nodes that gather."""

from functools import cache
from types import SimpleNamespace

import numpy as np
from scipy import sparse

from golden.cast.grid import Grid
from golden.light.form_factors import PatchRows
from golden.light.solvers import RadiositySystem
from golden.scene.builtin import builtin_scene
from golden.scene.halve import halved
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.projection_work import ProjectionWork

__all__ = ["drawn_matrix", "drawn_work", "room"]


@cache
def room(patches):
    """The Cornell box in so many patches: its scene, system and projections."""
    scene = halved(builtin_scene("cornell"), patches)
    factors = PatchRows(scene, Grid(scene), rays=(16, 8)).rows(np.arange(len(scene)))
    system = RadiositySystem(form_factors=factors, reflectance=scene.channels("diffuse"),
                             emission=scene.channels("emission"), area=scene.areas)
    return scene, system, ProjectionWork(scene, NodeTiming())


def drawn_work(seed, patches):
    """Projections with drawn times of each pair of patches."""
    pairs = np.random.default_rng(seed).integers(1_000, 2_000_000, (patches, patches))

    def of_blocks(block, blocks):
        return np.stack([pairs[:, block == one].sum(axis=1) for one in range(blocks)], axis=1)

    return SimpleNamespace(of_blocks=of_blocks, of_rows=700 + pairs.sum(axis=1) + 300, clearing=700, summing=300,
                           timing=NodeTiming())


def drawn_matrix(seed, rows, *, most):
    """A square matrix whose rows have 0 to ``most`` entries and sums below 1."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, most + 1, rows)
    columns = np.concatenate([rng.permutation(rows)[:count] for count in counts])
    return sparse.csr_array((rng.random(len(columns)) / (most + 1), columns, np.append(0, counts.cumsum())),
                            shape=(rows, rows))
