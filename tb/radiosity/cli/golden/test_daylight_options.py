"""Options of sky and sun reach the sky, and those that need one are refused without it."""

from datetime import UTC, datetime

import pytest

from golden.base.errors import InputError
from golden.scene.sky import daylight
from golden.scene.sky.sun_position import sun_position
from radiosity.cli.golden.daylight_options import daylight_of

GIVEN = dict.fromkeys(("sky", "sun", "date", "place", "sky_illuminance", "sun_illuminance", "weather", "ground",
                       "north"))


@pytest.mark.parametrize("sky", [None, (1.0, 2.0, 3.0)])
@pytest.mark.parametrize(("option", "values"), [
    ("sun", {"sun": (180.0, 40.0)}), ("date", {"date": datetime(2026, 6, 21, 12, tzinfo=UTC), "place": (52.0, 4.4)}),
    ("sky-illuminance", {"sky_illuminance": 9000.0}), ("sun-illuminance", {"sun_illuminance": 9000.0}),
    ("weather", {"weather": (600.0, 150.0)}), ("ground", {"ground": 0.2}), ("north", {"north": (1.0, 0.0, 0.0)})])
def test_what_needs_a_named_sky_is_refused_without_one(sky, option, values):
    with pytest.raises(InputError, match=f"^--{option} needs --sky with one of uniform, "):
        daylight_of(GIVEN | {"sky": sky} | values)


def test_every_value_reaches_the_sky(monkeypatch):
    monkeypatch.setattr(daylight, "Daylight", lambda **values: values)
    values = {"sky_illuminance": 9000.0, "sun_illuminance": 70_000.0, "weather": (600.0, 150.0), "ground": 0.3,
              "north": (1.0, 0.0, 0.0)}
    given = GIVEN | values | {"sky": "perez", "sun": (170.0, 40.0)}
    assert daylight_of(given) == values | {"sky": "perez", "sun": (170.0, 40.0)}
    assert given["sky"] is None
    date, place = datetime(2026, 6, 21, 9, tzinfo=UTC), (52.0, 4.4)
    assert daylight_of(GIVEN | values | {"sky": "uniform", "date": date, "place": place}) == values | {
        "sky": "uniform", "sun": sun_position(date, *place)}
