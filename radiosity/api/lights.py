"""Daylight and luminaires of scenes."""

import os
from datetime import datetime
from pathlib import Path

from golden.base.errors import InputError
from golden.light.photometry.quantities import EFFICACY, check_efficacy
from golden.scene.luminaires.luminaire import Luminaire
from golden.scene.scene import Scene
from golden.scene.sky.daylight import Daylight
from golden.scene.sky.sun_position import sun_position

__all__ = ["luminaire", "sky"]


def sky(scene: Scene, kind: str = "uniform", *, sun: tuple[float, float] | None = None, date: datetime | None = None,
        place: tuple[float, float] | None = None, sky_illuminance: float | None = None,
        sun_illuminance: float | None = None, weather: tuple[float, float] | None = None, ground: float = 0.2,
        north: tuple[float, float, float] | None = None, efficacy: float = EFFICACY) -> Scene:
    """The scene below a sky, with the sun among its lights.

    Parameters
    ----------
    scene
        The scene; the zenith is its up.
    kind
        uniform, cie-overcast, cie-clear or perez.
    sun
        Azimuth from north towards east and elevation in degrees.
    date, place
        In place of ``sun`` a moment with an offset from UTC, and latitude and longitude in degrees.
    sky_illuminance, sun_illuminance
        Diffuse horizontal and direct normal illuminance in lux. Default: by the kind of the sky.
    weather
        Direct normal and diffuse horizontal irradiance in W/m2, for perez.
    ground
        Reflectance of the ground, 0 to 1.
    north
        Direction of the north. Default: +y, or -z if up is +y.
    efficacy
        Luminous efficacy in lm/W, above 0.

    Raises
    ------
    InputError
        A value is out of range, or one that the sky depends on is missing.
    """
    check_efficacy(efficacy)
    if (date is None) != (place is None):
        raise InputError("sky: Date and place must be given together", parameter="date" if date is None else "place")
    if date is not None and place is not None:
        if sun is not None:
            raise InputError("sky: Sun must be given alone, or date and place", parameter="sun")
        sun = sun_position(date, *place)
    return Daylight(sky=kind, sun=sun, sky_illuminance=sky_illuminance, sun_illuminance=sun_illuminance,
                    weather=weather, ground=ground, north=north).scene(scene, efficacy)


def luminaire(scene: Scene, path: str | os.PathLike[str], place: tuple[float, float, float], *, turn: float = 0.0,
              efficacy: float = EFFICACY) -> Scene:
    """The scene with the luminaire of a .ies or .ldt file at a point.

    Parameters
    ----------
    scene
        The scene; the luminaire aims against its up, and lengths are metres.
    path, place
        The file, and the centre of the luminous opening.
    turn
        Degrees from x to C0, counter-clockwise as seen from above.
    efficacy
        Luminous efficacy in lm/W, above 0.

    Raises
    ------
    InputError
        The file cannot be used, or a value is not finite.
    """
    check_efficacy(efficacy)
    return Luminaire(path=Path(path), place=place, turn=turn).scene(scene, efficacy)
