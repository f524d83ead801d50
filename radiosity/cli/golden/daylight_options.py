"""Options of ``render`` for sky and sun."""

from datetime import datetime

import click

from golden.base.errors import InputError
from radiosity.cli.golden.choices import SKIES
from radiosity.cli.parameters import FiniteRange, Numbers, Positive

__all__ = ["DAYLIGHT", "DAYLIGHT_NAMED", "daylight_of"]


class _SkyValue(Numbers):
    """A radiance, or the name of a sky."""

    def __init__(self):
        super().__init__("R,G,B", least=0)

    def get_metavar(self, param, ctx):
        """What the help calls a value."""
        return "|".join((self.name, *SKIES))

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if value in SKIES:
            return value
        if not isinstance(value, tuple) and "," not in value:
            self.fail(f"{value!r} is neither {self.name} nor one of {', '.join(SKIES)}", param, ctx)
        return super().convert(value, param, ctx)


class _Date(click.ParamType):
    """A time in ISO 8601 form."""

    name = "DATETIME"

    def convert(self, value, param, ctx):
        """The value of what the user typed."""
        if isinstance(value, datetime):
            return value
        try:
            return datetime.fromisoformat(value)
        except ValueError:
            self.fail(f"{value!r} is not a date and time like 2026-06-21T12:00+02:00", param, ctx)


DAYLIGHT = (
    click.option("--sky", type=_SkyValue(), help="Set the radiance from outside the scene, or choose a sky over a "
                 "horizon.  [default: the scene's]"),
    click.option("--sun", type=Numbers("AZIMUTH,ELEVATION"), help="Set the sun's direction in degrees; azimuths count "
                 "from north towards east."),
    click.option("--date", type=_Date(), help="Compute the sun's direction at this date and time, such as "
                 "2026-06-21T12:00+02:00."),
    click.option("--place", type=Numbers("LATITUDE,LONGITUDE"), help="Compute it at this place, in degrees to the "
                 "north and to the east."),
    click.option("--sky-illuminance", type=Positive(), help="Set the diffuse horizontal illuminance in "
                 "lux.  [default: by the kind of the sky]"),
    click.option("--sun-illuminance", type=Positive(), help="Set the direct normal illuminance of the sun in lux.  "
                 "[default: by the kind of the sky]"),
    click.option("--weather", type=Numbers("DIRECT,DIFFUSE", least=0), help="Set the direct normal and diffuse "
                 "horizontal irradiance in W/m2, for sky perez."),
    click.option("--ground", type=FiniteRange(0, 1), help="Set the reflectance of the ground below the horizon of "
                 "a named sky.  [default: 0.2]"),
    click.option("--north", type=Numbers(), help="Set the direction of the north.  [default: +y, or -z if up is +y]"))
"""The options."""

DAYLIGHT_NAMED = {"sky": "--sky", "date": "--date", "place": "--place", "sun": "--sun", "north": "--north",
                  "sun_illuminance": "--sun-illuminance", "weather": "--weather"}
"""The option that gives each value, by its name as a parameter."""


def daylight_of(given: dict):
    """The `Daylight` of the values of these options, or None; of a named sky ``given["sky"]`` becomes None."""
    from golden.scene.sky.daylight import Daylight
    from golden.scene.sky.sun_position import sun_position

    named = given["sky"] if isinstance(given["sky"], str) else None
    sun, date, place = (given[name] for name in ("sun", "date", "place"))
    if (date is None) != (place is None):
        raise click.UsageError("--date and --place need each other.")
    if sun is not None and date is not None:
        raise click.UsageError("--sun excludes --date and --place.")
    if named is None:
        more = [name for name in ("sun", "date", "sky_illuminance", "sun_illuminance", "weather", "ground",
                              "north") if given[name] is not None]
        if more:
            raise InputError(f"--{more[0].replace('_', '-')} needs --sky with one of {', '.join(SKIES)}")
        return None
    given["sky"] = None
    return Daylight(sky=named, sun=sun if date is None else sun_position(date, *place), **{
        name: given[name] for name in ("sky_illuminance", "sun_illuminance", "weather", "ground", "north")
        if given[name] is not None})
