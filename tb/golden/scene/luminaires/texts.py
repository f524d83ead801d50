"""Texts of photometry for tests."""

import numpy as np

__all__ = ["eulumdat", "ies"]


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
