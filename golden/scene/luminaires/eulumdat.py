"""Luminaires in EULUMDAT files."""

import numpy as np

from golden.base.errors import InputError
from golden.scene.file_text import lines_of
from golden.scene.file_text import number as number_of
from golden.scene.luminaires.photometry_file import LARGEST, MOST_ANGLES, PhotometryFile, Words, mirrored
from golden.scene.unused import Unused

__all__ = ["read_eulumdat"]

# Numbers of lines, from 0: the head has 26 lines, a set of lamps 6, and ten direct ratios follow the sets.
_SYMMETRY, _PLANES, _GAMMAS, _LENGTH, _WIDTH, _FACTOR, _TILT, _SETS = 2, 3, 5, 15, 16, 23, 24, 25
_HEIGHTS = range(17, 21)
_SET, _RATIOS, _MOST_SETS = 6, 10, 20
# By symmetry the C planes at which the intensities begin or end and the light is mirrored, beside C0.
_CENTRES = {2: (180,), 3: (90, 270), 4: (90,)}


def read_eulumdat(data: bytes) -> PhotometryFile:
    """The photometry of an EULUMDAT text. Commas are decimal points.

    The planes of symmetry are among the C planes, as many of these on either side.

    Intensities per 1000 lumens are multiplied by the conversion factor and by the flux of the first set of lamps. C90
    is along the luminaire's length.

    Raises
    ------
    InputError
        The text is none, or a value cannot be used; the line is named.

    Warns
    -----
    InputWarning
        Names further sets of lamps, a tilt or a height of the opening, and numbers behind the intensities.

    Source: A. Stockmar, EULUMDAT: ein Leuchtendatenformat für den europäischen Beleuchtungsplaner (1990).
    """
    lines = lines_of(data)
    symmetry, count, gammas, sets = (_value(lines, number, whole=True) for number in (
        _SYMMETRY, _PLANES, _GAMMAS, _SETS))
    for name, number, value, low, high in (("Symmetry", _SYMMETRY, symmetry, 0, 4),
                                           ("Number of C planes", _PLANES, count, 1, MOST_ANGLES),
                                           ("Number of G angles", _GAMMAS, gammas, 2, MOST_ANGLES),
                                           ("Number of sets of lamps", _SETS, sets, 1, _MOST_SETS)):
        if not low <= value <= high:
            raise InputError(f"line {number + 1}: {name} must be {low} to {high}, not {value}")
    if symmetry in (2, 3, 4) and count % (4 if symmetry != 2 else 2):
        raise InputError(f"line {_PLANES + 1}: Number of C planes must be a multiple of {4 if symmetry != 2 else 2} "
                         f"with symmetry {symmetry}, not {count}")
    length, width = (_value(lines, number) / 1000 for number in (_LENGTH, _WIDTH))
    if min(length, width) < 0:
        raise InputError(f"line {_LENGTH + 1}: Sizes of the luminous area must be at least 0, not {length:g} and "
                         f"{width:g}")
    flux = _value(lines, _SETS + 3)
    first = _SETS + 1 + _SET * sets + _RATIOS
    words = Words(lines[first:], first + 1, commas=".")
    angles = words.numbers(count, "C angles")
    given = {0: count, 1: 1, 2: count // 2 + 1, 3: count // 2 + 1, 4: count // 4 + 1}[symmetry]
    for centre in _CENTRES.get(symmetry, ()):
        plane = count * centre // 360
        if angles[plane] != centre:
            raise InputError(f"line {words.line(plane)}: C angle {plane + 1} of {count} must be {centre} with symmetry "
                             f"{symmetry}, not {angles[plane]:g}")
    gamma = words.numbers(gammas, "G angles")
    values = words.numbers(given * gammas, "intensities").reshape(given, gammas)
    unused = Unused()
    unused.add("sets of lamps beside the first", sets - 1)
    unused.add("tilt during measurement", _is_stated(lines, _TILT))
    unused.add("height of the luminous area", any(_is_stated(lines, number) for number in _HEIGHTS))
    unused.add("numbers behind the intensities", words.left)
    unused.warn()
    planes, candela = _whole_turn(symmetry, angles, values * (_value(lines, _FACTOR) * flux / 1000))
    # A round opening states its diameter as the length alone.
    return PhotometryFile(gamma=gamma, planes=planes, candela=candela, opening=(width or length, length),
                          is_round=not width)


def _value(lines, number, *, whole=False):
    """The number in a line of its own."""
    if number >= len(lines):
        raise InputError(f"line {len(lines)}: the file ends before line {number + 1}")
    word = lines[number].strip().replace(",", ".")
    try:
        value = number_of(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value) or (whole and value != int(value)):
        raise InputError(f"line {number + 1}: it must be a {'whole' if whole else 'finite'} number, not {word!r}")
    if abs(value) > LARGEST:
        raise InputError(f"line {number + 1}: it must be at most {LARGEST:g}, not {word}")
    return int(value) if whole else value


def _is_stated(lines, number):
    """A value that is not used is there and is not 0."""
    return bool(lines[number].strip().strip("+-0,."))


def _whole_turn(symmetry, angles, candela):
    """The C planes of a whole turn from those of the file, which begin at 0 but for symmetry 3: that begins at 270."""
    if symmetry == 1:
        return np.zeros(1), candela
    if symmetry == 0:
        return np.append(angles, 360), np.concatenate([candela, candela[:1]])
    if symmetry == 3:
        half = len(candela) - 1
        planes = np.concatenate([angles[-(half // 2):] - 360, angles[:half // 2 + 1]])
        planes, candela = mirrored(planes, candela, 90)
        start = half // 2
        turned = np.concatenate([planes[start:], planes[1:start + 1] + 360])
        return turned, np.concatenate([candela[start:], candela[1:start + 1]])
    for centre in ((180,) if symmetry == 2 else (90, 180)):
        angles = angles[:len(candela)]
        angles, candela = mirrored(angles, candela, centre)
    return angles, candela
