"""What files of photometry have in common."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.scene.file_text import number as number_of

__all__ = ["LARGEST", "PhotometryFile", "Words", "mirrored"]

# Most angles of a file, and intensities.
MOST_ANGLES, MOST_VALUES = 4096, 1 << 22
# Largest magnitude of a number: products of several are finite.
LARGEST = 1e30


@dataclass(frozen=True, kw_only=True, eq=False)
class PhotometryFile:
    """The photometry of a luminaire.

    Parameters
    ----------
    gamma, planes, candela
        See `golden.scene.luminaires.photometric_web.PhotometricWeb`; C0 and C90 are the file's.
    opening
        Size of the luminous opening along C0 and along C90 in metres, at least 0.
    is_round
        Whether the opening is an ellipse with these axes, not a rectangle.
    """

    gamma: np.ndarray
    planes: np.ndarray
    candela: np.ndarray
    opening: tuple[float, float]
    is_round: bool


class Words:
    """The numbers of a text, one after the other.

    Parameters
    ----------
    lines
        Lines of text.
    first
        The number of the first of them, for errors.
    commas
        What a comma stands for: a blank or a decimal point.
    """

    def __init__(self, lines: list[str], first: int, *, commas: str):
        self._words = [(word, number) for number, line in enumerate(lines, first)
                       for word in line.replace(",", commas).split()]
        self._next = 0
        self._last = first + max(0, len(lines) - 1)

    @property
    def left(self) -> int:
        """How many numbers follow."""
        return len(self._words) - self._next

    def number(self, what: str) -> float:
        """The next number.

        Raises
        ------
        InputError
            The text ends, or the next word is none.
        """
        if self._next >= len(self._words):
            raise InputError(f"line {self._last}: the file ends before {what}")
        word, line = self._words[self._next]
        self._next += 1
        try:
            value = number_of(word)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise InputError(f"line {line}: {what.capitalize()} must be a finite number, not {word!r}")
        if abs(value) > LARGEST:
            raise InputError(f"line {line}: {what.capitalize()} must be at most {LARGEST:g}, not {word}")
        return value

    def count(self, what: str) -> int:
        """The next number, which is whole and 1 to `MOST_ANGLES`."""
        value = self.number(what)
        if value != int(value) or not 1 <= value <= MOST_ANGLES:
            raise InputError(f"line {self.line(self._next - 1)}: {what.capitalize()} must be a whole number of 1 to "
                             f"{MOST_ANGLES}, not {value:g}")
        return int(value)

    def line(self, place: int) -> int:
        """The line of the number at a place, from 0."""
        return self._words[place][1]

    def numbers(self, count: int, what: str) -> np.ndarray:
        """The next ``count`` numbers."""
        if count > MOST_VALUES:
            raise InputError(f"{what.capitalize()} must be at most {MOST_VALUES} numbers, not {count}")
        return np.array([self.number(what) for _ in range(count)])


def mirrored(planes: np.ndarray, candela: np.ndarray, centre: float) -> tuple[np.ndarray, np.ndarray]:
    """C planes on both sides of a plane of symmetry: those given, which end there, and their mirror images."""
    keep = slice(-2, None, -1)
    return np.concatenate([planes, 2 * centre - planes[keep]]), np.concatenate([candela, candela[keep]])
