"""Luminaires in files of IESNA LM-63."""


import numpy as np

from golden.errors import InputError
from golden.input_warnings import warn
from golden.plural import counted
from golden.scene.luminaires.photometry_file import PhotometryFile, Words, mirrored

__all__ = ["read_ies"]

_FOOT = 0.3048
# Last horizontal angles, and where the light is mirrored to make a whole turn of them.
_SYMMETRIES = {90: (90, 180), 180: (180,), 360: ()}


def read_ies(text: str) -> PhotometryFile:
    """The photometry of a text in LM-63-1986 to LM-63-2019, of type C.

    Intensities are multiplied by the candela multiplier and the ballast factors. C0 is along the luminaire's length.
    Horizontal angles 90 to 270 are those of a light with symmetry about the plane of C90 and C270.

    Raises
    ------
    InputError
        The text is none of these, or a value cannot be used; the line is named.

    Warns
    -----
    InputWarning
        The light depends on the lamp's tilt, which is not used, or more numbers follow.

    Source: ANSI/IES LM-63-19; I. Ashdown, Parsing the IESNA LM-63 photometric data file (1998).
    """
    lines = text.splitlines()
    start = next((number for number, line in enumerate(lines) if line.strip().upper().startswith("TILT=")), None)
    if start is None:
        raise InputError("it has no line TILT=")
    words = Words(lines[start + 1:], start + 2)
    tilt = lines[start].strip()[5:].strip().upper()
    if tilt != "NONE":
        warn("the dependence on the lamp's tilt is not used")
    if tilt == "INCLUDE":
        words.number("lamp to luminaire geometry")
        words.numbers(2 * words.count("number of tilt angles"), "tilt angles and factors")
    words.numbers(2, "lamps and their lumens")
    multiplier = words.number("candela multiplier")
    vertical, horizontal = words.count("number of vertical angles"), words.count("number of horizontal angles")
    kind, unit = words.number("photometric type"), words.number("type of units")
    if kind != 1:
        raise InputError(f"Photometric type must be 1 (type C), not {kind:g}")
    if unit not in (1, 2):
        raise InputError(f"Type of units must be 1 (feet) or 2 (metres), not {unit:g}")
    width, length, _ = words.numbers(3, "width, length and height")
    ballast, lamp, _ = words.numbers(3, "ballast factors and input watts")
    gamma = words.numbers(vertical, "vertical angles")
    planes = words.numbers(horizontal, "horizontal angles")
    values = words.numbers(vertical * horizontal, "candela values").reshape(horizontal, vertical)
    if words.left:
        warn(f"{counted(words.left, 'number')} after the candela values not used (does it have decimal "
             "commas?)")
    planes, candela = _whole_turn(planes, values * (multiplier * ballast * lamp))
    # Negative sizes are diameters.
    metres = _FOOT if unit == 1 else 1.0
    return PhotometryFile(gamma=gamma, planes=planes, candela=candela,
                          opening=(abs(length) * metres, abs(width) * metres))


def _whole_turn(planes, candela):
    if len(planes) == 1:
        return np.zeros(1), candela
    if (planes[0], planes[-1]) == (90, 270) and (90 + 270 - planes[::-1] == planes).all():
        turned, light = mirrored(planes, candela, 270)
        order = np.argsort(turned[:-1] % 360, kind="stable")
        planes, candela = (turned[:-1] % 360)[order], light[:-1][order]
        if planes[0] > 0:
            raise InputError("Horizontal angles of 90 to 270 degrees must have 180 among them")
        return np.append(planes, 360), np.concatenate([candela, candela[:1]])
    if planes[0] != 0 or planes[-1] not in _SYMMETRIES:
        raise InputError(f"Horizontal angles must be 0 alone, 0 to 90, 0 to 180, 90 to 270 or 0 to 360 degrees, not "
                         f"{planes[0]:g} to {planes[-1]:g}")
    for centre in _SYMMETRIES[planes[-1]]:
        planes, candela = mirrored(planes, candela, centre)
    return planes, candela
