"""The frustum record: a bundle of rays in the machine's integers."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.base.errors import InputError
from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Numbers
from golden.engine.frustum.bundle import Bundle
from golden.engine.lib.fixed import ceil_sqrt, round_shift
from golden.engine.scene.g_coordinates import GCoordinates

__all__ = ["LEAST_Z_SCALE", "FrustumRecord", "hemisphere_record", "screen_record", "screen_slope_scale"]

LEAST_Z_SCALE = 32
"""Least `FrustumRecord.z_scale` of a screen: depths and slopes are off by at most 4.3 % of themselves."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrustumRecord:
    """Parameters of one bundle of rays, from the host to the machine.

    Ray ``row * columns + column`` has the direction, in the R frame and signed 1.16,

    * hemisphere: (sin p cos a, sin p sin a, cos p), p from the row and a from the column, products rounded;
    * screen: (x, y, 1), x from the column and y from the row.

    Parameters
    ----------
    is_screen
        Whether the bundle is a screen; else it is a hemisphere.
    numbers
        Widths of the integers.
    origin
        3 int64, G coordinates.
    matrix
        3 x 3 int64 signed 1.16, G to R. It includes a screen's field of view: the longest row is of unit length.
    to_global
        3 x 3 int64 signed 1.16: directions of grid rays to G. Hemisphere: from R. Screen: from (slopes divided by
        `slope_scale`, and 1) to the ray's direction divided by `slope_scale`.
    z_scale
        Unsigned 1.16: a point at depth z along the view (or the normal) has the R coordinate ``z_scale`` z.
    half_angles
        (h_x, h_y): the slopes of a screen at x = 1 and y = 1; (1, 1) for a hemisphere.
    columns, rows
        Rays: azimuths and polars, or pixels.
    column_bits, row_bits
        Binary logarithms of the sizes of the full grid, of which the rays are the middle; all of it in a hemisphere.
    column_table
        Hemisphere: ``columns`` x 2 int64, cos and sin of the azimuth. Screen: ``columns`` x 1, x.
    row_table
        Hemisphere: ``rows`` x 2 int64, sin and cos of the polar angle. Screen: ``rows`` x 1, y.
    source
        The surface (`Scene.surface`) that the rays start on and never hit, or -1.
    """

    is_screen: bool
    numbers: Numbers
    origin: np.ndarray
    matrix: np.ndarray
    to_global: np.ndarray
    z_scale: int
    half_angles: tuple[float, float]
    columns: int
    rows: int
    column_bits: int
    row_bits: int
    column_table: np.ndarray
    row_table: np.ndarray
    source: int = -1

    def __len__(self) -> int:
        return self.columns * self.rows

    @property
    def bundle(self) -> Bundle:
        """The kind of the rays."""
        return Bundle.SCREEN if self.is_screen else Bundle.HEMISPHERE

    @property
    def slopes(self) -> tuple[float, float]:
        """Slopes of a screen's border, in x and y."""
        return tuple(angle * count / 2.0**bits for angle, count, bits in zip(
            self.half_angles, (self.columns, self.rows), (self.column_bits, self.row_bits), strict=True))

    @property
    def slope_scale(self) -> float:
        """Ratio of a grid ray's parameter to its distance (hemisphere: 1) or depth (screen)."""
        return screen_slope_scale(self.slopes) if self.is_screen else 1.0

    @property
    def least_z_scale(self) -> float:
        """Lower bound of the R coordinate z of a point on a ray, divided by its depth; a hemisphere's `z_scale`."""
        if not self.is_screen:
            return self.z_scale
        return self.z_scale - 0.5 - 0.5 * np.sqrt(3) * np.linalg.norm([*self.slopes, 1.0])

    def view_coordinates(self, offset: np.ndarray) -> np.ndarray:
        """Offsets from a screen's origin in G along the R axes, K x 3, to the precision of `to_global`."""
        return offset @ self.to_global * [1.0, 1.0, self.slope_scale] / 2.0**self.numbers.direction_fraction

    def directions(self, column, row) -> np.ndarray:
        """Directions of the rays in ``column`` and ``row`` (arrays that broadcast): ... x 3 int64, signed 1.16."""
        column, row = np.broadcast_arrays(column, row)
        if self.is_screen:
            one = np.full(column.shape, 1 << self.numbers.direction_fraction, dtype=np.int64)
            return np.stack([self.column_table[column, 0], self.row_table[row, 0], one], axis=-1)
        sine, cosine = self.row_table[row, 0], self.row_table[row, 1]
        across = round_shift(sine[..., None] * self.column_table[column], self.numbers.direction_fraction)
        return np.concatenate([across, cosine[..., None]], axis=-1)

    def all_directions(self) -> np.ndarray:
        """Directions of all rays in the order of their numbers: R x 3 int64, signed 1.16."""
        return self.directions(np.arange(self.columns), np.arange(self.rows)[:, None]).reshape(-1, 3)

    @property
    def spread(self) -> int:
        """Largest distance, in x and in y, of a ray from the middle of its position in the grid: units of 2^-16."""
        return 0

    def corner_directions(self, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Directions at the corners of P parts of a screen, P x 2 x 2 x 3 int64: their rays are between them.

        Parameters
        ----------
        columns, rows
            P x 2, the first and the last column and row of each part.
        """
        return self.directions(columns[:, :, None], rows[:, None, :])

    @cached_property
    def longest_direction(self) -> int:
        """Upper bound of the lengths of a hemisphere's directions, in units of 2^-16."""
        if self.is_screen:
            raise TypeError("longest_direction is of hemispheres only")
        directions = self.all_directions()
        return int(ceil_sqrt((directions * directions).sum(axis=1).max()[None])[0])


def screen_slope_scale(slopes) -> float:
    """A screen's `FrustumRecord.slope_scale`: scaled slopes are below 2, also of grid rays beyond the border."""
    return 1.125 * max(*slopes, 1.0)


def hemisphere_record(hemisphere: Hemisphere, coordinates: GCoordinates, origin, normal, *,
                      source: int = -1, axes=None) -> FrustumRecord:
    """A hemisphere around a surface normal.

    Parameters
    ----------
    hemisphere, coordinates
        The grid of rays, and the coordinates of the scene.
    origin, normal
        Scene point and direction (of any length).
    source
        The surface of the point, or -1.
    axes
        3 x 3 float64, rows as those of `frame`, which is the default.

    Raises
    ------
    InputError
        The origin is outside the coordinates, or the normal is zero or not finite.
    """
    normal = np.asarray(normal, dtype=np.float64)
    length = np.linalg.norm(normal)
    if not np.isfinite(length) or not length > 0:
        raise InputError(f"frustum: Normal must be finite and not zero, not {normal.tolist()!r}", parameter="normal")
    numbers = coordinates.numbers
    axes = frame(normal / length) if axes is None else np.asarray(axes, dtype=np.float64)
    encode = numbers.direction.encode
    polar = (2 * np.arange(hemisphere.polars) + 1) * (np.pi / 4 / hemisphere.polars)
    azimuth = (2 * np.arange(hemisphere.azimuths) + 1) * (np.pi / hemisphere.azimuths)
    matrix = encode(axes, "frustum matrix")
    return FrustumRecord(
        is_screen=False, numbers=numbers, origin=coordinates.integers(origin), matrix=matrix, to_global=matrix.T.copy(),
        z_scale=1 << numbers.direction_fraction, half_angles=(1.0, 1.0),
        columns=hemisphere.azimuths, rows=hemisphere.polars,
        column_bits=hemisphere.azimuths.bit_length() - 1, row_bits=hemisphere.polars.bit_length() - 1,
        column_table=encode(np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1), "azimuth table"),
        row_table=encode(np.stack([np.sin(polar), np.cos(polar)], axis=1), "polar table"), source=source)


def screen_record(screen: Screen, coordinates: GCoordinates) -> FrustumRecord:
    """The pixels of a picture, row 0 on top.

    The rays are the middle of a grid of powers of two that spans x and y from -1 to 1. Neither axis' slope at 1 is
    below both half the other's and 1/2, so that M's rows keep their bits. The R axes are right, down and forward.

    Raises
    ------
    InputError
        The eye is outside the coordinates, the picture is too large, or its field of view is too narrow.
    """
    numbers = coordinates.numbers
    bits = [max(1, (size - 1).bit_length()) for size in (screen.width, screen.height)]
    bits = np.maximum(bits, int(min(max(bits) - 1, np.ceil(-np.log2(screen.pitch)))))
    if max(bits) > numbers.direction_fraction:
        raise InputError(f"frustum: Picture must be at most {1 << numbers.direction_fraction} pixels wide and high, "
                         f"not {screen.width} x {screen.height}")
    half = np.append(screen.pitch * 2.0 ** (bits - 1), 1.0)
    axes = screen.camera.axes * [[1], [-1], [1]]
    z_scale = half.min()
    least = LEAST_Z_SCALE / 2**numbers.direction_fraction
    if z_scale < least:
        narrowest = np.degrees(2 * np.arctan(least * screen.height / 2.0 ** bits.min()))
        raise InputError(f"frustum: Field of view must be at least {narrowest:.3g} degrees for {screen.width} x "
                         f"{screen.height} pixels, not {screen.camera.fov!r}", parameter="fov")
    encode = numbers.direction.encode
    x, y = (encode((2 * np.arange(size) + 1 - size) / 2.0**bit, "screen table")[:, None]
            for size, bit in zip((screen.width, screen.height), bits, strict=True))
    slope_scale = screen_slope_scale(half[:2] * (screen.width, screen.height) / 2.0**bits)
    return FrustumRecord(
        is_screen=True, numbers=numbers, origin=coordinates.integers(screen.camera.eye),
        matrix=encode(axes * (z_scale / half)[:, None], "frustum matrix"),
        to_global=encode(axes.T / [1, 1, slope_scale], "frustum matrix"),
        z_scale=int(encode(z_scale, "z scale")), half_angles=(float(half[0]), float(half[1])),
        columns=screen.width, rows=screen.height, column_bits=int(bits[0]), row_bits=int(bits[1]),
        column_table=x, row_table=y)
