"""Drawn photometric webs, and their intensities by the definition."""

from bisect import bisect_right

import numpy as np
from hypothesis import strategies as st

__all__ = ["folded", "intensity", "symmetric_tables", "web_tables"]


@st.composite
def web_tables(draw) -> dict:
    """Draws ``gamma``, ``planes`` and ``candela`` of a web: C planes all around or one, G angles often to an end."""
    low, high = draw(st.sampled_from(((0, 180), (0, 90), (90, 180), (0, 120), (30, 60))))
    between = draw(st.sets(st.integers(low + 1, high - 1), max_size=3))
    gamma = sorted({low, high} | between)
    planes = [0] if draw(st.booleans()) else sorted({0, 360} | draw(st.sets(st.integers(1, 359), max_size=3)))
    rows = [[draw(st.integers(0, 9)) for _ in gamma] for _ in planes]
    rows[-1] = rows[-1] if len(planes) == 1 else rows[0]
    # On the axis all planes are one direction.
    rows = [[first if angle in (0, 180) else value for angle, first, value in zip(gamma, rows[0], row, strict=True)]
            for row in rows]
    return {"gamma": gamma, "planes": planes, "candela": rows}


# By the planes about which the light is symmetric the C angles of which it is given: C0 with C180, C90 with C270.
_GIVEN = {(): (0, 360), ("C0",): (0, 180), ("C90",): (90, 270), ("C0", "C90"): (0, 90)}


@st.composite
def symmetric_tables(draw) -> dict:
    """Draws ``mirrors``, the planes of symmetry, and ``gamma``, ``planes`` and ``candela`` of the part that is given.

    C planes are evenly spaced, a multiple of four in a whole turn; the light is the same in C0 and C360.
    """
    mirrors = draw(st.sampled_from(sorted(_GIVEN)))
    low, high = _GIVEN[mirrors]
    planes = list(range(low, high + 1, draw(st.sampled_from((30, 45, 90)))))
    gamma = sorted({0, 90} | draw(st.sets(st.integers(1, 89), max_size=2)))
    candela = [[draw(st.integers(0, 9)) for _ in gamma] for _ in planes]
    if not mirrors:
        candela[-1] = candela[0]
    return {"mirrors": mirrors, "gamma": gamma, "planes": planes, "candela": candela}


def folded(mirrors: tuple[str, ...], plane: int) -> int:
    """The C angle of the given part at which a symmetric light has the intensity of a C angle from 0 to 360."""
    if "C0" in mirrors:
        plane = min(plane, 360 - plane)
    if "C90" in mirrors and not _GIVEN[mirrors][0] <= plane <= _GIVEN[mirrors][1]:
        plane = (180 - plane) % 360
    return plane


def intensity(table: dict, gamma: float, plane: float) -> float:
    """The intensity of a web at an angle, 0 to 180, and a plane, 0 to 360: bilinear, 0 beyond the G angles."""
    if not table["gamma"][0] <= gamma <= table["gamma"][-1]:
        return 0.0

    def along(row):
        return np.interp(gamma, table["gamma"], row)

    if len(table["planes"]) == 1:
        return float(along(table["candela"][0]))
    first = min(bisect_right(table["planes"], plane) - 1, len(table["planes"]) - 2)
    low, high = table["planes"][first:first + 2]
    share = (plane - low) / (high - low)
    return float((1 - share) * along(table["candela"][first]) + share * along(table["candela"][first + 1]))
