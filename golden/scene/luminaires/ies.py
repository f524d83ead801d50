"""Luminaires in files of IESNA LM-63."""

import re

import numpy as np

from golden.base.errors import InputError
from golden.base.input_warnings import warn
from golden.scene.file_text import lines_of
from golden.scene.luminaires.photometry_file import PhotometryFile, Words, mirrored
from golden.scene.unused import Unused

__all__ = ["read_ies"]

_FOOT = 0.3048
# Last horizontal angles, and where the light is mirrored to make a whole turn of them.
_SYMMETRIES = {90: (90, 180), 180: (180,), 360: ()}

_TILT = re.compile(r"\s*TILT\s*=\s*(.*?)\s*", re.IGNORECASE)
_EDITION = re.compile(r"\s*IES(?:NA)?:LM-63-(\d+)", re.IGNORECASE)
# From this edition on both sizes of a round opening are negative.
_BOTH_NEGATIVE = 2002
# From this edition on a second ballast factor is the type of the file's generation.
_GENERATION_TYPES = 2019


def read_ies(data: bytes) -> PhotometryFile:
    """The photometry of a text in LM-63-1986 to LM-63-2019, of type C.

    Intensities are multiplied by the candela multiplier and the ballast factors, of which LM-63-2019 has one. C0 is
    along the luminaire's length. Horizontal angles 90 to 270 are those of a light with symmetry about the plane of C90
    and C270. Commas separate numbers; if that does not give their count, they are decimal points.

    Raises
    ------
    InputError
        The text is none of these, or a value cannot be used; the line is named.

    Warns
    -----
    InputWarning
        Names a dependence on the lamp's tilt and a height of the opening; more numbers follow, or commas are decimal
        points.

    Source: ANSI/IES LM-63-19; I. Ashdown, Parsing the IESNA LM-63 photometric data file (1998).
    """
    lines = lines_of(data)
    start = next((number for number, line in enumerate(lines) if _TILT.fullmatch(line)), None)
    if start is None:
        raise InputError("it has no line TILT=")
    tilt = _TILT.fullmatch(lines[start])[1].upper()
    edition = _EDITION.match(next(filter(str.strip, lines)))
    edition = int(edition[1]) if edition else 0

    def read(commas):
        unused = Unused()
        words = Words(lines[start + 1:], start + 2, commas=commas)
        return _photometry(words, tilt, edition=edition, unused=unused), words.left, unused

    try:
        found, left, unused = read(" ")
        fault = None
    except InputError as error:
        found, left, unused, fault = None, 0, None, error
    if (left or fault) and any(re.search(r"\d,\d", line) for line in lines[start + 1:]):
        try:
            other, rest, named = read(".")
        except InputError:
            rest = 1
        if not rest:
            warn("its commas are taken for decimal points")
            found, left, unused, fault = other, 0, named, None
    if fault:
        raise fault
    unused.add("numbers behind the candela values", left)
    unused.warn()
    return found


def _photometry(words, tilt, *, edition, unused):
    """The photometry of the numbers behind the line TILT=."""
    unused.add("dependence on the lamp's tilt", tilt != "NONE")
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
    width, length, height = words.numbers(3, "width, length and height")
    ballast, lamp, _ = words.numbers(3, "ballast factors and input watts")
    if edition >= _GENERATION_TYPES:
        unused.add(f"type of generation {lamp:g}", not 1 <= lamp < 2)
        lamp = 1
    gamma = words.numbers(vertical, "vertical angles")
    planes = words.numbers(horizontal, "horizontal angles")
    values = words.numbers(vertical * horizontal, "candela values").reshape(horizontal, vertical)
    unused.add("height of the luminous opening", height != 0)
    planes, candela = _whole_turn(planes, values * (multiplier * ballast * lamp))
    metres = _FOOT if unit == 1 else 1.0
    (length, width), is_round = _opening(length, width, height, edition=edition)
    return PhotometryFile(gamma=gamma, planes=planes, candela=candela, opening=(length * metres, width * metres),
                          is_round=is_round)


def _opening(length, width, height, *, edition):
    """Level sizes of a luminous opening, and whether it is round; negative sizes are diameters.

    A circle has one negative size until 1995, an ellipse one beside a positive one; since 2002 both have two. Where the
    height is a diameter too, a single negative size since 2002, or none until 1995, is that of a cylinder that lies.
    """
    is_round = min(length, width) < 0 and not (height < 0 <= max(length, width) and edition >= _BOTH_NEGATIVE)
    if is_round:
        length, width = length or width, width or length
    elif height < 0 < max(length, width) and edition < _BOTH_NEGATIVE:
        length, width = length or height, width or height
    return (abs(length), abs(width)), is_round


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
