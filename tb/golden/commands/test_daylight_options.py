"""Options of sky and sun that need a sky are refused without one."""

from datetime import UTC, datetime

import pytest

from golden.commands.daylight_options import daylight_of
from golden.errors import InputError

GIVEN = dict.fromkeys(("sky", "sun", "date", "place", "sky_illuminance", "sun_illuminance", "weather", "north"))


@pytest.mark.parametrize("sky", [None, (1.0, 2.0, 3.0)])
@pytest.mark.parametrize(("option", "values"), [
    ("sun", {"sun": (180.0, 40.0)}), ("date", {"date": datetime(2026, 6, 21, 12, tzinfo=UTC), "place": (52.0, 4.4)}),
    ("sky-illuminance", {"sky_illuminance": 9000.0}), ("sun-illuminance", {"sun_illuminance": 9000.0}),
    ("weather", {"weather": (600.0, 150.0)}), ("north", {"north": (1.0, 0.0, 0.0)})])
def test_what_needs_a_named_sky_is_refused_without_one(sky, option, values):
    with pytest.raises(InputError, match=f"^--{option} needs --sky with one of uniform, "):
        daylight_of(GIVEN | {"sky": sky, "ground": 0.2} | values)
