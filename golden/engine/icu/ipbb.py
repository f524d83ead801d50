"""IPBB: the window of pixels of a patch seen through a screen."""

import numpy as np

from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.edge_planes import DIAGONAL, EDGES, EdgePlanes
from golden.engine.icu.window import Window, make_window
from golden.engine.lib.cordic import linear, linear_error, normalise

__all__ = ["ImagePlaneWindows"]


class ImagePlaneWindows:
    """The IPBB block for one screen.

    Per patch and axis: the smallest and the largest x/z (y/z) of the vertices in front of the eye, widened by the
    error of CORDIC. Where an edge passes behind the eye the window extends to the border of the screen, on the side
    that the sign of the edge plane gives. A patch with no vertex in front has no window.

    Source: docs/exactness.md, Windows.
    """

    def __init__(self, record: FrustumRecord, config: Config):
        self._record, self._config = record, config
        self.error = linear_error(config.icu, config.numbers.vertex_bits)

    def windows(self, directions: np.ndarray, planes: EdgePlanes) -> Window:
        """The windows of P patches, from their V' (P x 4 x 3 int64) and edge planes."""
        record = self._record
        front = directions[..., 2] > 0
        # An edge meets the plane z = 0 in the direction (x, y) = (n_y, -n_x), from the end in front to the one behind.
        first, second = (front[:, [edge[end] for edge in EDGES[:DIAGONAL + 1]]] for end in range(2))
        crosses = first != second
        crosses[~planes.split, DIAGONAL] = False
        side = np.where(first, 1, -1)
        edges = planes.planes[:, :DIAGONAL + 1]
        column = self._range(directions[..., 0], directions[..., 2], front, crosses, side * edges[..., 1])
        row = self._range(directions[..., 1], directions[..., 2], front, crosses, -side * edges[..., 0])
        return make_window(record, ~(front.any(axis=1) & planes.orientation.any(axis=1)),
                           *self._indices(*column, record.columns, record.column_bits),
                           *self._indices(*row, record.rows, record.row_bits))

    def quotients(self, across: np.ndarray, z: np.ndarray) -> np.ndarray:
        """``across / z`` of vertices in units of 2^-``cordic_stages``, clipped to -1 and 1; 1 or -1 where z <= 0."""
        one = 1 << self._config.icu.cordic_stages
        outside = np.abs(across) >= z
        y, x, _ = normalise(np.where(outside, 0, across), np.where(outside, 1, z), self._config.numbers.vertex_bits)
        return np.where(outside, np.where(across < 0, -one, one), linear(y, x, self._config.icu))

    def _range(self, across, z, front, crosses, runs):
        """Smallest and largest quotient of each patch."""
        one = 1 << self._config.icu.cordic_stages
        quotient = self.quotients(across, z)
        low = np.where(front, quotient, one).min(axis=1) - self.error
        high = np.where(front, quotient, -one).max(axis=1) + self.error
        return (np.where((crosses & (runs <= 0)).any(axis=1), -one, low),
                np.where((crosses & (runs >= 0)).any(axis=1), one, high))

    def _indices(self, low, high, size, bits):
        """First and last of the table entries (2 i + 1 - size) / 2^bits that are in [low, high].

        Of a frustum whose rays are apart from the middles also those that are within half an entry's width.
        """
        stages = self._config.icu.cordic_stages
        middle, half = (size - 1) << stages, (self._record.spread > 0) << stages
        return -((-(low << bits) - middle + half) >> (stages + 1)), ((high << bits) + middle + half) >> (stages + 1)
