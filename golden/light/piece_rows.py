"""Rows of form factors of pieces of elements, cast when they shoot, and the light at nodes that follows."""

from collections.abc import Callable

import numpy as np
from scipy import sparse

from golden.base.spread import Spread
from golden.cast.hemisphere import Hemisphere
from golden.light.contacts import PARTS
from golden.light.elements import Elements
from golden.light.node_rows import NodeRows, Rows
from golden.light.pieces import Pieces
from golden.light.surface_points import bilinear
from golden.scene.scene import Scene

__all__ = ["PieceRows"]


class PieceRows:
    """Casts one hemisphere from the middle of a piece, whose row is kept.

    It stands in for the `Rows` of the nodes, which are not cast: light is interpolated to them from the pieces.

    Parameters
    ----------
    scene, elements, pieces
        The patches, their elements, and the pieces of these.
    rows
        Casts hemispheres at points.
    hemisphere, spread
        The grid of rays, and what casts spans of hemispheres.

    Members
    -------
    cast
        Number of the hemispheres cast.
    groups
        The channels of each group; there is one, as no patch is clear or a flat mirror.
    sky, buried
        M x 3 and M: as those of `Rows`. No sky is seen; nodes count as outside bodies until `settle` has been called.
    """

    def __init__(self, scene: Scene, elements: Elements, pieces: Pieces, rows: NodeRows, hemisphere: Hemisphere,
                 spread: Spread):
        self._rows, self._hemisphere, self._spread, self._pieces = rows, hemisphere, spread, pieces
        self.groups, self.sky = rows.groups, np.zeros((len(elements.lattice), 3))
        self.buried = np.zeros(len(elements.lattice), dtype=bool)
        self._source = scene.surface[elements.patch[pieces.element]]
        self._normal = elements.normal[pieces.element]
        self._middle = elements.centre[pieces.element].copy()
        element, piece, column, row, across, inside = pieces.points(1)
        cut = np.flatnonzero((across == PARTS) & ~inside)
        # The first part of a cut element that is outside bodies stands for all of its piece.
        some, first = np.unique(piece[cut], return_index=True)
        cut = cut[first]
        self._middle[some] = bilinear(elements.vertices[element[cut]], (column[cut] + 0.5) / PARTS,
                                      (row[cut] + 0.5) / PARTS)
        self._known: dict[int, sparse.csr_array] = {}

    @property
    def cast(self) -> int:
        """See above."""
        return len(self._known)

    def of_pieces(self, _) -> list[Callable[[np.ndarray], sparse.csr_array]]:
        """For the one group of channels the function from pieces to their rows that a `RadiositySystem` takes."""
        return [self._of]

    def settle(self, irradiance: np.ndarray, received: np.ndarray) -> np.ndarray:
        """The nodes' irradiance over pi, M x 3: the mean of the pieces around each that light has reached.

        Parameters
        ----------
        irradiance
            P x 3: that of the pieces.
        received
            P bool: which pieces a shot has reached; the others are inside bodies, or all dark.
        """
        share = (self._pieces.of_corners.T @ sparse.diags_array(np.where(received, self._pieces.area, 0.0))).tocsr()
        total = share.sum(axis=1)
        self.buried = total == 0
        return (share @ irradiance) / np.where(self.buried, 1.0, total)[:, None]

    def _of(self, ids):
        missing = np.array([one for one in ids.tolist() if one not in self._known], dtype=np.int64)
        if len(missing):
            found: Rows = self._rows.cast(self._middle[missing], self._normal[missing], self._source[missing],
                                          self._hemisphere, self._spread)
            for place, one in enumerate(missing.tolist()):
                self._known[one] = found.factors[0][[place]]
        return sparse.vstack([self._known[one] for one in ids.tolist()]).tocsr()
