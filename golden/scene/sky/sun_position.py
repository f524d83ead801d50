"""The position of the sun."""

from datetime import UTC, datetime

import numpy as np

from golden.base.errors import InputError

__all__ = ["sun_position"]

_J2000 = datetime(2000, 1, 1, 12, tzinfo=UTC)
# Years for which the approximation has its accuracy.
_YEARS = (1950, 2050)


def sun_position(moment: datetime, latitude: float, longitude: float) -> tuple[float, float]:
    """Azimuth and elevation of the sun's centre in degrees, without refraction, within 0.01 degrees.

    Parameters
    ----------
    moment
        A time with its offset from UTC, 1950 to 2050.
    latitude, longitude
        Degrees; north and east are positive.

    Returns
    -------
    Azimuth from north towards east, 0 to 360, and elevation, -90 to 90.

    Raises
    ------
    InputError
        The time has no offset or is out of range, or there is no such place.

    Source: Michalsky, The Astronomical Almanac's algorithm for approximate solar position (1988).
    """
    if moment.tzinfo is None:
        raise InputError(f"sun: Date must have an offset from UTC, as 2026-06-21T12:00+02:00 has, not be "
                         f"{moment.isoformat()!r}", parameter="date")
    if not _YEARS[0] <= moment.year <= _YEARS[1]:
        raise InputError(f"sun: Date must be in {_YEARS[0]} to {_YEARS[1]}, not {moment.isoformat()!r}",
                         parameter="date")
    if not (-90 <= latitude <= 90 and -180 <= longitude <= 180):
        raise InputError(f"sun: Place must be a latitude of -90 to 90 and a longitude of -180 to 180, not "
                         f"{latitude!r},{longitude!r}", parameter="place")
    days = (moment - _J2000).total_seconds() / 86400
    mean_longitude = 280.460 + 0.9856474 * days
    anomaly = np.radians(357.528 + 0.9856003 * days)
    ecliptic = np.radians(mean_longitude + 1.915 * np.sin(anomaly) + 0.020 * np.sin(2 * anomaly))
    obliquity = np.radians(23.439 - 0.0000004 * days)
    ascension = np.arctan2(np.cos(obliquity) * np.sin(ecliptic), np.cos(ecliptic))
    declination = np.arcsin(np.sin(obliquity) * np.sin(ecliptic))
    # The sidereal time grows by a little more than a turn in a day: 18.697375 hours at J2000.
    sidereal = 15 * (18.697375 + 24.06570982442 * days) + longitude
    hour = np.radians(sidereal) - ascension
    north = np.radians(latitude)
    elevation = np.arcsin(np.sin(declination) * np.sin(north) + np.cos(declination) * np.cos(north) * np.cos(hour))
    azimuth = np.arctan2(-np.cos(declination) * np.sin(hour),
                         np.sin(declination) * np.cos(north) - np.cos(declination) * np.sin(north) * np.cos(hour))
    return float(np.degrees(azimuth) % 360), float(np.degrees(elevation))
