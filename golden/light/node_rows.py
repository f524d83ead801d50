"""Rows of form factors from points to elements, with the sky that the points see."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.base.spread import Spread, in_turn
from golden.cast.density import Density
from golden.cast.hemisphere import Hemisphere
from golden.light.form_factors import hemisphere_sums
from golden.light.glass import ClearRays, Glass
from golden.light.pieces import Pieces
from golden.light.tally import Tally
from golden.scene.scene import Scene
from golden.scene.sky.sky import Sky

__all__ = ["NodeRows", "Rows", "joined"]

# A point is inside a body if backs of one-sided patches fill more than this share of its hemisphere.
BURIED = 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class Rows:
    """What M points see.

    Parameters
    ----------
    factors
        For each group of channels that sees glass equally clear the sparse M x P form factors to pieces of elements.
    groups
        The channels of each group.
    sky
        M x 3: irradiance over pi from outside the scene, and from the lamps that mirrors show.
    buried
        M bool: whether the point is inside a body.
    """

    factors: list[sparse.csr_array]
    groups: list[list[int]]
    sky: np.ndarray
    buried: np.ndarray

    def of_pieces(self, mean: sparse.csr_array) -> list[sparse.csr_array]:
        """For each group the form factors from pieces to pieces: ``mean`` is their sparse P x M interpolation."""
        return [(mean @ matrix).tocsr() for matrix in self.factors]

    def gathered(self, radiosity: np.ndarray) -> np.ndarray:
        """Irradiance over pi, M x 3, if the P pieces have these radiosities, P x 3."""
        return joined(self.groups, [matrix @ radiosity for matrix in self.factors]) + self.sky


class NodeRows:
    """Casts hemispheres at points, one for each group of channels.

    Parameters
    ----------
    scene, pieces, glass
        The patches, the pieces of their elements, and which patches are clear or mirrors.
    frusta, caster
        Caster of hemispheres, and caster of the rays behind glass and from mirrors.
    tally
        Counts the rays, as kinds ``"hemisphere"`` and ``"transmission"``.
    density
        See `hemisphere_sums`.
    progress
        Shows a progress bar after two seconds.
    """

    def __init__(self, scene: Scene, pieces: Pieces, glass: Glass, *, frusta, caster, tally: Tally,
                 density: Density | None = None, progress: bool = False):
        self._scene, self._pieces, self._density, self._progress = scene, pieces, density, progress
        self._frusta = tally.counting("hemisphere", frusta)
        self.groups = glass.colours
        self.clear = [ClearRays(scene, glass, tally.counting("transmission", caster), channels[0])
                       for channels in self.groups] if glass.goes_on.any() else [None]

    def cast(self, position: np.ndarray, normal: np.ndarray, source: np.ndarray, hemisphere: Hemisphere,
             spread: Spread = in_turn) -> Rows:
        """The rows of M points: M x 3 positions and unit normals, and the surface of each, or -1.

        ``spread`` casts spans of the hemispheres, by default one after the other.
        """
        factors, skies, buried = [], [], []
        sky = self._scene.background.radiance if isinstance(self._scene.background, Sky) else None
        for clear in self.clear:
            sums = hemisphere_sums(self._frusta, hemisphere, position, normal, source, columns=len(self._pieces),
                                   column_of=self._pieces.seen, clear=clear, sky=sky, density=self._density,
                                   spread=spread, progress=self._progress)
            unit = 2.0**-sums.weight_bits
            factors.append(sparse.csr_array((sums.weights.data * unit, sums.weights.indices, sums.weights.indptr),
                                            shape=sums.weights.shape))
            hit = sums.row_sums * unit
            # Of a uniform sky the share that is not hit is exact.
            outside = (1 - hit)[:, None] * np.asarray(self._scene.background) if sky is None else 0.0
            skies.append(outside + sums.light * unit)
            buried.append(hit - factors[-1].sum(axis=1) > BURIED)
        return Rows(factors=factors, groups=self.groups, sky=joined(self.groups, skies),
                    buried=np.logical_and.reduce(buried))


def joined(groups: list[list[int]], values: list[np.ndarray]) -> np.ndarray:
    """One array of three channels from those of groups of channels, each right in its own channels."""
    result = values[0].copy()
    for channels, value in zip(groups, values, strict=True):
        result[:, channels] = value[:, channels]
    return result
