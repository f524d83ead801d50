"""Luminaires as lights of a scene."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.input_warnings import caught_warnings, warn
from golden.scene.lights import PointLight
from golden.scene.luminaires.eulumdat import read_eulumdat
from golden.scene.luminaires.ies import read_ies
from golden.scene.luminaires.photometric_web import PhotometricWeb
from golden.scene.luminaires.photometry_file import PhotometryFile
from golden.scene.parser import check_regular
from golden.scene.scene import Scene

__all__ = ["Luminaire"]

_READERS = {".ies": read_ies, ".ldt": read_eulumdat}
# Points along each side of a luminous opening that share its light; even.
POINTS = 4
# Largest file, in bytes.
_LARGEST = 1 << 26


@dataclass(frozen=True, kw_only=True)
class Luminaire:
    """A luminaire that aims against the scene's up.

    Its luminous opening, a level rectangle or ellipse, shines as `POINTS` x `POINTS` points of the same intensities by
    direction in the middles of equal areas; one without a size as one point. Lengths of the scene are metres.

    Parameters
    ----------
    path
        A file of LM-63 (.ies) or EULUMDAT (.ldt).
    place
        The opening's centre.
    turn
        Degrees from the scene's x axis (if that is its up, y) to C0, counter-clockwise as seen from above.

    Raises
    ------
    InputError
        Place or turn is not finite.
    """

    path: Path
    place: tuple[float, float, float]
    turn: float = 0.0

    def __post_init__(self):
        if not np.isfinite((*self.place, self.turn)).all():
            raise InputError(f"luminaire: Place and turn must be finite, not {self.place!r} and {self.turn!r}",
                             parameter="place")

    def scene(self, scene: Scene, efficacy: float) -> Scene:
        """The scene with this luminaire among its lights, for ``efficacy`` in lm/W.

        Raises
        ------
        InputError
            The file cannot be read; one line with its path.
        """
        try:
            with caught_warnings() as caught:
                found = self._read()
                axes = self._axes(scene)
                web = PhotometricWeb(gamma=found.gamma, planes=found.planes, candela=found.candela, axes=axes)
                if not found.candela.any():
                    warn("it emits no light")
        except InputError as error:
            raise InputError(f"{self.path}: {error}", parameter="path") from error
        for message in caught:
            warn(f"{self.path}: {message}")
        places = [np.array(self.place) + x * found.opening[0] * axes[0] + y * found.opening[1] * axes[1]
                  for x, y in _places(found)]
        watts = (1 / (efficacy * len(places)),) * 3
        lights = tuple(PointLight(position=tuple(place.tolist()), intensity=watts, web=web) for place in places)
        return replace(scene, lights=scene.lights + lights)

    def _axes(self, scene):
        up = np.array(scene.up, dtype=np.float64) / np.linalg.norm(scene.up)
        first = np.array((0.0, 1, 0) if abs(up[0]) > 0.9 else (1.0, 0, 0))
        first -= (first @ up) * up
        first /= np.linalg.norm(first)
        second = np.cross(up, first)
        turn = np.radians(self.turn)
        return np.stack([np.cos(turn) * first + np.sin(turn) * second,
                         np.cos(turn) * second - np.sin(turn) * first, -up])

    def _read(self):
        suffix = self.path.suffix.lower()
        if suffix not in _READERS:
            raise InputError(f"Suffix must be {' or '.join(_READERS)}, not {self.path.suffix!r}")
        check_regular(self.path)
        try:
            data = self.path.read_bytes() if self.path.stat().st_size <= _LARGEST else None
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})") from error
        if data is None:
            raise InputError(f"it is larger than {_LARGEST} bytes")
        return _READERS[suffix](data)


def _places(found: PhotometryFile):
    """Points of an opening, in shares of its size from its centre."""
    if max(found.opening) == 0:
        return [(0.0, 0.0)]
    if found.is_round:
        # Ring k of radii k to k + 1 has 4 (2 k + 1) points, each for the same area, on the circle that halves the ring.
        return [(radius * np.cos(angle), radius * np.sin(angle)) for k in range(POINTS // 2)
                for radius in [np.hypot(k, k + 1) / np.sqrt(2) / POINTS]
                for angle in 2 * np.pi * (np.arange(4 * (2 * k + 1)) + 0.5) / (4 * (2 * k + 1))]
    steps = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    return [(x, y) for x in steps for y in steps]
