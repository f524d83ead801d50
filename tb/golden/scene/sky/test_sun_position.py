from datetime import UTC, datetime, timedelta, timezone

import pytest

from golden.base.errors import InputError
from golden.scene.sky.sun_position import sun_position

MOUNTAIN = timezone(timedelta(hours=-7))


def test_position_of_the_solar_position_algorithms_example():
    """Reda and Andreas, Solar Position Algorithm (NREL/TP-560-34302), appendix A.5: without refraction."""
    azimuth, elevation = sun_position(datetime(2003, 10, 17, 12, 30, 30, tzinfo=MOUNTAIN), 39.742476, -105.1786)
    assert azimuth == pytest.approx(194.340241, abs=0.01)
    assert elevation == pytest.approx(39.872046, abs=0.01)


def test_elevation_at_the_pole_is_the_declination():
    """Meeus, Astronomical Algorithms, example 25.a: -7.78507 degrees, 59 s of dynamical time earlier."""
    elevation = sun_position(datetime(1992, 10, 12, 23, 59, 1, tzinfo=UTC), 90, 0)[1]
    assert elevation == pytest.approx(-7.78507, abs=0.01)


def test_the_sun_rises_in_the_east_and_is_high_at_noon():
    azimuths = [sun_position(datetime(2026, 3, 20, hour, tzinfo=UTC), 48, 0)[0] for hour in (7, 12, 17)]
    assert 80 < azimuths[0] < 110 < 175 < azimuths[1] < 185 < 250 < azimuths[2] < 280
    south = sun_position(datetime(2026, 6, 21, 12, tzinfo=UTC), -48, 0)
    assert min(south[0], 360 - south[0]) < 5
    assert 15 < south[1] < 20


def test_the_offset_counts():
    here = datetime(2026, 6, 21, 14, tzinfo=timezone(timedelta(hours=2)))
    assert sun_position(here, 48, 11) == sun_position(here.astimezone(UTC), 48, 11)


@pytest.mark.parametrize(("moment", "place", "message"), [
    (datetime(2026, 6, 21), (0, 0), "Date must have an offset"),
    (datetime(1900, 6, 21, tzinfo=UTC), (0, 0), "Date must be in 1950 to 2050"),
    (datetime(2026, 6, 21, tzinfo=UTC), (91, 0), "Place must be"),
    (datetime(2026, 6, 21, tzinfo=UTC), (0, float("nan")), "Place must be")])
def test_impossible_times_and_places_are_refused(moment, place, message):
    with pytest.raises(InputError, match=message):
        sun_position(moment, *place)
