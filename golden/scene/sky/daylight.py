"""Sun and sky of a scene, by their illuminances or by the weather."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from golden.base.errors import InputError, check_choice
from golden.base.input_warnings import warn
from golden.scene.lights import DirectionalLight
from golden.scene.material import BRIGHTEST
from golden.scene.scene import Scene
from golden.scene.sky.compass import compass
from golden.scene.sky.distributions import cie_clear, cie_overcast, perez, uniform
from golden.scene.sky.sky import Sky
from golden.scene.sky.weather import Weather

__all__ = ["SKIES", "Daylight"]

SKIES = ("uniform", "cie-overcast", "cie-clear", "perez")

# Diffuse horizontal illuminance in lux without a sun: a hundredth of it is a daylight factor of one per cent.
UNKNOWN = 10_000.0
# Solar illuminance constant in lux, and the optical extinction of a clear atmosphere.
_EXTRATERRESTRIAL, _EXTINCTION = 127_500.0, 0.21


@dataclass(frozen=True, kw_only=True)
class Daylight:
    """A sky, the ground below it, and the sun.

    Parameters
    ----------
    sky
        One of `SKIES`.
    sun
        Azimuth from north towards east and elevation of the sun in degrees, or None.
    sky_illuminance
        Diffuse horizontal illuminance, lux. Default: that of the weather, else by the sun's elevation
        300 + 21000 sin(e) if it is overcast and 800 + 15500 sin(e)^(1/2) if it is clear, else 10,000.
    sun_illuminance
        Direct normal illuminance, lux. Default: that of the weather, else 127,500 exp(-0.21 / sin(e))
        under a clear sky, else none.
    weather
        Direct normal and diffuse horizontal irradiance in W/m2: what sky ``perez`` depends on, and no other.
    ground
        Reflectance of the ground, 0 to 1, outside the scene.
    north
        See `golden.scene.sky.compass.compass`.

    Raises
    ------
    InputError
        A value is out of range, or one that the sky depends on is missing.

    Sources: CIE S 011 (2003); Gillette, Pierpoint, Treado, A general illuminance model for daylight availability
    (1984); Perez and others, Modeling daylight availability (1990).
    """

    sky: str = "uniform"
    sun: tuple[float, float] | None = None
    sky_illuminance: float | None = None
    sun_illuminance: float | None = None
    weather: tuple[float, float] | None = None
    ground: float = 0.2
    north: tuple[float, float, float] | None = None

    def __post_init__(self):
        check_choice("daylight: Sky", self.sky, SKIES, parameter="sky")
        if self.sun is not None and not (np.isfinite(self.sun).all() and -90 <= self.sun[1] <= 90):
            raise InputError(f"daylight: Sun must be an azimuth and an elevation of -90 to 90 degrees, not "
                             f"{self.sun!r}", parameter="sun")
        if self.sky in ("cie-clear", "perez") and (self.sun is None or self.sun[1] <= 0):
            found = "nowhere" if self.sun is None else f"at an elevation of {self.sun[1]:.4g} degrees"
            raise InputError(f"daylight: Sun must be above the horizon with sky {self.sky}, not {found}",
                             parameter="sun")
        for name in ("sky_illuminance", "sun_illuminance"):
            value = getattr(self, name)
            if value is not None and not 0 <= value <= BRIGHTEST:
                raise InputError(f"daylight: {name.capitalize().replace('_', ' ')} must be at least 0 and at most "
                                 f"{BRIGHTEST:g}, not {value!r}", parameter=name)
        if self.sun_illuminance and self.sun is None:
            raise InputError("daylight: Sun illuminance must have a sun, not be alone", parameter="sun_illuminance")
        if not 0 <= self.ground <= 1:
            raise InputError(f"daylight: Ground must be 0 to 1, not {self.ground!r}")
        if (self.weather is not None) != (self.sky == "perez"):
            raise InputError(f"daylight: Weather must be given with sky perez alone, not with sky {self.sky}"
                             if self.weather else "daylight: Weather must be given with sky perez, not be missing",
                             parameter="weather")
        if self.weather is not None:
            self._weather.check()

    def scene(self, scene: Scene, efficacy: float) -> Scene:
        """The scene with this background and with the sun among its lights, for ``efficacy`` in lm/W.

        Warns
        -----
        InputWarning
            A uniform sky has a sun without an illuminance, or a sun with one is not above the horizon: it changes
            nothing.
        """
        axes = compass(scene.up, self.north)
        up = axes[2]
        toward = up if self.sun is None else self._toward(axes)
        sine = float(up @ toward)
        diffuse, direct = self._illuminances(sine)
        if self.sky == "uniform" and self.sun is not None and self.sun_illuminance is None:
            warn("daylight: the sun is not used: with sky uniform it shines only if its illuminance is given")
        if sine <= 0:
            if direct:
                warn(f"daylight: the sun is not used: it is not above the horizon, but at {self.sun[1]:.4g} degrees")
            direct = 0.0
        horizontal = diffuse + direct * sine
        sky = Sky(distribution=self._distribution(), diffuse=diffuse / efficacy, up=up, sun=toward,
                  ground=self.ground * horizontal / efficacy / np.pi)
        sun = () if not direct else (DirectionalLight(direction=tuple((-toward).tolist()),
                                                      irradiance=(direct / efficacy,) * 3),)
        return replace(scene, background=sky, lights=scene.lights + sun)

    def _toward(self, axes):
        azimuth, elevation = np.radians(self.sun)
        level = np.cos(azimuth) * axes[1] + np.sin(azimuth) * axes[0]
        return np.cos(elevation) * level + np.sin(elevation) * axes[2]

    def _illuminances(self, sine):
        """Diffuse horizontal and direct normal illuminance."""
        diffuse, direct = UNKNOWN, 0.0
        if self.sky == "perez":
            diffuse, direct = self._weather.illuminances
        elif self.sky == "cie-clear":
            diffuse, direct = 800 + 15_500 * sine**0.5, _EXTRATERRESTRIAL * np.exp(-_EXTINCTION / sine)
        elif self.sky == "cie-overcast" and self.sun is not None:
            diffuse = 300 + 21_000 * max(sine, 0)
        return (diffuse if self.sky_illuminance is None else self.sky_illuminance,
                direct if self.sun_illuminance is None else self.sun_illuminance)

    def _distribution(self):
        if self.sky == "perez":
            return perez(self._weather.clearness, self._weather.brightness, self._weather.zenith)
        return {"uniform": uniform, "cie-overcast": cie_overcast, "cie-clear": cie_clear}[self.sky]()

    @cached_property
    def _weather(self):
        direct, diffuse = self.weather
        return Weather(direct=direct, diffuse=diffuse, zenith=float(np.radians(90 - self.sun[1])))
