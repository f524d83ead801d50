"""Divisions of the sky into patches."""

import numpy as np

from golden.scene.sky.compass import compass

__all__ = ["SKY_DIVISIONS", "SkyDivision"]

SKY_DIVISIONS = {"tregenza": 1, "reinhart": 2}
"""Name: parts into which the height and the width of Tregenza's patches are cut."""

# Patches of Tregenza's bands, from the horizon up; the last patch is the zenith, of half a band's height.
_BANDS = np.array([30, 30, 24, 24, 18, 12, 6])


class SkyDivision:
    """Numbers of sky patches, as in Radiance: 0 is all below the horizon, then bands from the horizon to the zenith.

    The first patch of a band has its middle in the north (`golden.scene.sky.compass.compass`); they count to the east.
    Bands have equal heights, the patches of one equal widths: 145 patches above the horizon by Tregenza, 577 by
    Reinhart.

    Parameters
    ----------
    name
        One of `SKY_DIVISIONS`.
    up
        The scene's up.

    Sources: Tregenza, Subdivision of the sky hemisphere for luminance measurements (1987); Bourgeois, Reinhart, Ward,
    Standard daylight coefficient model for dynamic daylighting simulations (2008).
    """

    def __init__(self, name: str, up=(0, 0, 1)):
        self._axes = compass(up)
        parts = SKY_DIVISIONS[name]
        self._bands = np.repeat(_BANDS, parts) * parts
        self._start = np.concatenate([[1], 1 + np.cumsum(self._bands)])
        self._height = np.pi / 2 / (len(self._bands) + 0.5)

    def __len__(self) -> int:
        """Sky patches, that below the horizon among them."""
        return int(self._start[-1]) + 1

    def numbers(self, direction: np.ndarray) -> np.ndarray:
        """The patch of each of K x 3 unit vectors, K int64."""
        # Not by a matrix product, whose rounding may depend on K.
        x, y, z = (direction[:, 0] * axis[0] + direction[:, 1] * axis[1] + direction[:, 2] * axis[2]
                   for axis in self._axes)
        band = (np.arcsin(np.clip(z, 0, 1)) / self._height).astype(np.int64)
        zenith = band >= len(self._bands)
        count = self._bands[np.where(zenith, 0, band)]
        sector = np.floor(np.arctan2(x, y) / (2 * np.pi) * count + 0.5).astype(np.int64) % count
        number = self._start[np.minimum(band, len(self._bands))] + np.where(zenith, 0, sector)
        return np.where(z < 0, 0, number)
