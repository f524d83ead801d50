"""Texts of photometry for tests."""

from collections.abc import Callable

import numpy as np
from hypothesis import strategies as st

from tb.golden.scene.dialects import encoded

__all__ = ["eulumdat", "eulumdat_dialects", "ies", "ies_dialects"]


def ies(*, vertical=(0, 45, 90), horizontal=(0,), candela=None, tilt="NONE", kind=1, unit=2, multiplier=1.0,
        size=(0.0, 0.0, 0.0), ballast=1.0, lamp=1) -> str:
    """A file of LM-63; candela is C x G, lamp the second ballast factor."""
    candela = np.full((len(horizontal), len(vertical)), 100.0) if candela is None else np.asarray(candela)
    rows = [f"1 1000 {multiplier} {len(vertical)} {len(horizontal)} {kind} {unit} {' '.join(map(str, size))}",
            f"{ballast} {lamp} 50", " ".join(map(str, vertical)), " ".join(map(str, horizontal)),
            *(" ".join(map(str, row)) for row in candela.tolist())]
    return "\n".join(["IESNA:LM-63-2002", "[TEST] none", f"TILT={tilt}", *rows]) + "\n"


def eulumdat(*, symmetry=1, planes=(0,), gamma=(0, 45, 90), candela=None, flux=1000.0, factor=1.0, size=(0, 0),
             sets=1) -> str:
    """An EULUMDAT file; candela is per 1000 lm, of the C planes that the symmetry leaves.

    Only the first of several sets of lamps has the flux, the others have 7 lm.
    """
    candela = np.full((1, len(gamma)), 100.0) if candela is None else np.asarray(candela)
    head = ["maker", 1, symmetry, len(planes), 0, len(gamma), 0, "report", "lamp", "1", "a.ldt", "today", 600, 600, 90,
            *size, 0, 0, 0, 0, 100, 100, factor, 0, sets]
    lamps = [entry for lumens in [flux, *[7] * (sets - 1)][:sets] for entry in (1, "LED", lumens, "4000", "80", 10)]
    values = [*planes, *gamma, *candela.ravel().tolist()]
    return "\n".join(map(str, [*head, *lamps, *[0.5] * 10, *values])) + "\n"


@st.composite
def ies_dialects(draw) -> Callable[[str], bytes]:
    """Draws how a program writes a text of `ies`: ends of lines, encoding, blanks, commas, breaks, the line TILT=."""
    separator = draw(st.sampled_from((" ", "  ", "\t", ", ", "\n", "\n  ")))
    point = draw(st.sampled_from(".,")) if "," not in separator else "."
    tilt = draw(st.sampled_from(("TILT=NONE", "TILT = NONE", " tilt=none ")))
    first = draw(st.sampled_from(("IESNA:LM-63-2002", "IESNA91", "[OTHER] Büro", "IES:LM-63-2019")))

    def write(text):
        head, _, numbers = text.partition("TILT=NONE")
        numbers = numbers.replace(".", point).replace(" ", separator)
        lines = [first, *head.splitlines()[1:], "[MORE] a, b …", tilt]
        return encoded(draw, "\n".join(lines) + numbers)
    return write


@st.composite
def eulumdat_dialects(draw) -> Callable[[str], bytes]:
    """Draws how a program writes a text of `eulumdat`: ends of lines, encoding, decimal points or commas, blanks."""
    point, blank = draw(st.sampled_from(".,")), draw(st.sampled_from(("", " ", "\t")))
    name = draw(st.sampled_from(("maker", "Büro … GmbH", "a\u2028b", "")))

    def write(text):
        _, *lines = text.replace(".", point).splitlines()
        return encoded(draw, "\n".join([name, *(blank + line + blank for line in lines)]) + "\n")
    return write
