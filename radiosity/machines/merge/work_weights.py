"""Work weights: what triangles, spans and pixels count in the load of a region."""

from dataclasses import dataclass

from golden.base.errors import InputError, check_int

__all__ = ["TRIANGLES_ALONE", "WorkWeights"]


@dataclass(frozen=True, kw_only=True)
class WorkWeights:
    """Operations on a triangle, a span and a pixel of the volume renderer; those of a node are weighted sums.

    The source chose the weights by trial and does not print them. Ours are counted: a triangle enters and leaves a
    list, with 3 corners moved (28 each) and 3 edges prepared (10 each); a span has two edges advanced by 5, is clipped
    (4) and entered (10); a pixel has its z advanced and compared (2), a midpoint (2), 4 distances (9 each), 4
    reciprocals and products (8), a value and its colour (8), and a composition (8).

    Parameters
    ----------
    triangle, span, pixel
        Whole numbers of at least 0, not all 0.

    Raises
    ------
    TypeError
        A weight is no int.
    InputError
        A weight is below 0, or all are 0.

    Source: Kurc 1997, section 6.4, Eq. 6.4.
    """

    triangle: int = 120
    span: int = 24
    pixel: int = 64

    def __post_init__(self):
        for name in ("triangle", "span", "pixel"):
            check_int(name.capitalize(), getattr(self, name))
            if getattr(self, name) < 0:
                raise InputError(f"volume: Weight of a {name} must be at least 0, not {getattr(self, name)!r}")
        if not self.triangle + self.span + self.pixel:
            raise InputError("volume: Weights must not all be 0")


TRIANGLES_ALONE = WorkWeights(triangle=1, span=0, pixel=0)
"""What splitters count without spans and pixels."""
