"""What has become of a publication's figure in a simulation."""

__all__ = ["BAND", "grade", "grade_of", "signed"]

# Of a ratio that is reproduced, and of two times that are the same.
BAND, _SAME = 0.15, 0.02


def grade(simulated: float, source: float) -> str:
    """Of a ratio: within 15 % and on the source's side of 1, if it is on one; on its side; or not."""
    side, expected = (0 if abs(ratio - 1) <= _SAME else 1 if ratio > 1 else -1 for ratio in (simulated, source))
    return grade_of(abs(simulated / source - 1) <= BAND and (side == expected or expected == 0), side == expected)


def grade_of(is_reproduced: bool, has_shape: bool = False) -> str:
    """The word for a figure that is reproduced; or has the source's shape at least; or neither."""
    return "reproduced" if is_reproduced else "same shape" if has_shape else "not reproduced"


def signed(error: float, digits: int = 1) -> str:
    """A relative error in percent, with its sign."""
    return f"{100 * error:+.{digits}f} %"
