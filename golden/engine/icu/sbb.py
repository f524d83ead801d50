"""SBB: the window of azimuths and polar angles of a patch seen from a hemisphere's origin."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from golden.engine.config import Config, Icu
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.edge_planes import DIAGONAL, EDGES, EdgePlanes
from golden.engine.icu.window import Window, make_window
from golden.engine.lib.cordic import circular, circular_error, gain, normalise
from golden.engine.lib.fixed import round_shift

__all__ = ["SphericalWindows", "WindowErrors", "sagitta_table", "window_errors"]

# Fraction bits of the gain by which z is multiplied for the second CORDIC.
GAIN_FRACTION = 16
# A sagitta is stored in units of a quarter turn / 2^12, rounded up.
SAGITTA_BITS = 12


@dataclass(frozen=True, kw_only=True)
class WindowErrors:
    """Upper bounds of errors, in units of 2^-``angle_bits`` turns.

    Parameters
    ----------
    azimuth, polar
        Of a vertex' angles by CORDIC.
    polar_slack
        Of the polar angle of a table direction.
    """

    azimuth: int
    polar: int
    polar_slack: int


@cache
def window_errors(config: Config) -> WindowErrors:
    """The error bounds of a configuration; docs/exactness.md derives them."""
    icu, numbers = config.icu, config.numbers
    turn = 2.0**icu.angle_bits / (2 * np.pi)
    azimuth = circular_error(icu, numbers.vertex_bits)
    # The length for the second CORDIC is truncated once per stage and once when it is shifted back; the gain of z is
    # rounded.
    length = (icu.cordic_stages * np.sqrt(2) + 2) / 2.0 ** (numbers.vertex_bits - 1 + icu.cordic_guard)
    return WindowErrors(azimuth=azimuth, polar=azimuth + int(np.ceil((length + 2.0**-GAIN_FRACTION / 2) * turn)),
                        polar_slack=int(np.ceil(_table_error(config) * turn)))


def _table_error(config):
    """Distance of a table direction from the exact one: three roundings by half a unit per component."""
    return 2.0 ** (1 - config.numbers.direction_fraction)


class SphericalWindows:
    """The SBB block for one hemisphere: its windows hold all table directions that may hit a patch.

    Azimuth: that of the four vertices, followed in the direction in which each edge runs around the axis (the sign of
    the edge plane's z), widened by the errors of CORDIC and of the tables; the whole ring if the axis meets the patch
    or the span exceeds a half turn. Polar angle: that of the vertices, less the sagitta of each edge (`sagitta_table`);
    from 0 if the normal meets the patch, and at most the horizon.

    Source: Shen 1993, Theorem 3.1 and Eq. 3.5; the sagitta also by polar angle, and the cases that the thesis omits.
    """

    def __init__(self, record: FrustumRecord, config: Config):
        self._record, self._config = record, config
        icu = config.icu
        errors = window_errors(config)
        self.azimuth_error, self.polar_error = errors.azimuth, errors.polar
        self.polar_slack = errors.polar_slack
        off = _table_error(config)
        sine = np.sin((2 * np.arange(record.rows) + 1) * (np.pi / 4 / record.rows))
        half = 1 << (icu.angle_bits - 1)
        # Rows so near the pole that the tables' error rotates them by more than a radian get the whole ring.
        rotated = np.ceil(off / sine * 2.0**icu.angle_bits / (2 * np.pi))
        self.azimuth_slack = np.where(off < sine, rotated, half).astype(np.int64)
        self._gain = round(gain(icu) * 2**GAIN_FRACTION)

    def angles(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Azimuth and polar angle of vertices V' (... x 3), in units of 2^-``angle_bits`` turns.

        A polar angle may be below 0 or above a half turn by up to `polar_error`.
        """
        icu, bits = self._config.icu, self._config.numbers.vertex_bits
        x, y, by = normalise(directions[..., 0], directions[..., 1], bits)
        azimuth, length = circular(x << icu.cordic_guard, y << icu.cordic_guard, icu)
        z = round_shift(directions[..., 2] * self._gain, GAIN_FRACTION - icu.cordic_guard)
        polar, _ = circular(z, length >> by, icu)
        quarter = 1 << (icu.angle_bits - 2)
        return azimuth, (polar + quarter & 4 * quarter - 1) - quarter

    def windows(self, directions: np.ndarray, planes: EdgePlanes) -> Window:
        """The windows of P patches.

        Parameters
        ----------
        directions
            P x 4 x 3 int64, V'.
        planes
            The edge planes of these patches.
        """
        record, icu = self._record, self._config.icu
        quarter, half = 1 << (icu.angle_bits - 2), 1 << (icu.angle_bits - 1)
        azimuth, polar = self.angles(directions)
        around = np.sign(planes.planes[:, :DIAGONAL + 1, 2])
        pole, nadir = _axis_inside(around, planes.orientation)

        turn = _edge_turns(azimuth, around, half)
        lowest = _lowest(polar - self.polar_error, np.abs(turn) + 2 * self.azimuth_error, planes.split, icu)
        lowest = np.where(pole, 0, lowest) - self.polar_slack
        highest = np.minimum(polar.max(axis=1) + self.polar_error, quarter) + self.polar_slack
        row_first, row_last = _indices(lowest, highest, icu.angle_bits - 2 - record.row_bits)

        followed = azimuth[:, :1] + np.concatenate(
            [np.zeros((len(turn), 1), dtype=np.int64), np.cumsum(turn[:, :3], axis=1)], axis=1)
        slack = self.azimuth_error + self.azimuth_slack[np.clip(row_first, 0, record.rows - 1)]
        left, right = followed.min(axis=1) - slack, followed.max(axis=1) + slack
        ring = pole | nadir | (right - left > half)
        column_first, column_last = _indices(left, right, icu.angle_bits - record.column_bits)
        return make_window(record, ~planes.orientation.any(axis=1), np.where(ring, 0, column_first),
                           np.where(ring, record.columns - 1, column_last), row_first, row_last)


@cache
def sagitta_table(icu: Icu) -> np.ndarray:
    """Sagitta of an edge: how much nearer to the pole than its lower end it comes, at most.

    Entry [p, s] holds for ends with a polar angle in the p-th part of a quarter turn (the smaller of the two) whose
    azimuths differ by at most the upper end of the s-th part of a half turn. The worst edge has both ends at that polar
    angle: its middle is at atan(tan(polar) cos(span / 2)).

    Returns
    -------
    2^``sagitta_polar_bits`` x 2^``sagitta_span_bits`` int64, in units of a quarter turn / 2^12, rounded up.
    """
    border = np.linspace(0, np.pi / 2, 2**icu.sagitta_polar_bits + 1)[:, None]
    cosine = np.cos(np.linspace(0, np.pi / 2, 2**icu.sagitta_span_bits + 1)[1:])
    # For one span the sagitta is largest where tan(polar)^2 = 1 / cosine.
    worst = np.clip(np.arctan(1 / np.sqrt(cosine)), border[:-1], border[1:])
    sagitta = worst - np.arctan2(np.sin(worst) * cosine, np.cos(worst))
    return np.ceil(sagitta / (np.pi / 2) * 2**SAGITTA_BITS).astype(np.int64)


def _axis_inside(around, orientation):
    """Whether the R frame's z axis meets the patch, upwards and downwards: P bool each.

    It does where no edge of one of the two triangles passes it on the outer side; zero counts as inside.
    """
    diagonal = around[:, DIAGONAL]
    triangles = (np.stack([around[:, 0], around[:, 1], -diagonal], axis=1),
                 np.stack([diagonal, around[:, 2], around[:, 3]], axis=1))
    inside = [[(orientation[:, which] != 0) & (side * orientation[:, which, None] * edges >= 0).all(axis=1)
               for which, edges in enumerate(triangles)] for side in (1, -1)]
    return inside[0][0] | inside[0][1], inside[1][0] | inside[1][1]


def _edge_turns(azimuth, around, half):
    """Change of the azimuth along edges and the diagonal: P x 5, signed.

    The sign is that of the edge plane's z, also where the change is near 0 or a half turn.
    """
    first, second = (azimuth[:, [edge[end] for edge in EDGES[:DIAGONAL + 1]]] for end in range(2))
    least = np.where(around == 0, -half, -(half >> 1))
    turn = (np.where(around < 0, first - second, second - first) - least) % (2 * half) + least
    return np.where(around < 0, -turn, turn)


def _lowest(polar, span, split, icu):
    """The smallest polar angle on the edges of each patch: of each edge the lower end less its sagitta."""
    quarter = 1 << (icu.angle_bits - 2)
    lower = np.stack([np.minimum(polar[:, i], polar[:, j]) for i, j in EDGES[:DIAGONAL + 1]], axis=1)
    part = np.clip(lower, 0, quarter - 1) >> (icu.angle_bits - 2 - icu.sagitta_polar_bits)
    span = np.minimum(span >> (icu.angle_bits - 1 - icu.sagitta_span_bits), (1 << icu.sagitta_span_bits) - 1)
    sagitta = sagitta_table(icu)[part, span] << (icu.angle_bits - 2 - SAGITTA_BITS)
    reach = np.where(lower < quarter, lower - sagitta, lower)
    # The diagonal is part of the border only where the patch is split.
    reach[~split, DIAGONAL] = reach[~split, 0]
    return reach.min(axis=1)


def _indices(low, high, bits):
    """First and last of the angles (2 i + 1) 2^(bits - 1) that are in [low, high]."""
    half = 1 << (bits - 1)
    return (low + half - 1) >> bits, (high - half) >> bits
