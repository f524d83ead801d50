"""Units of length of scenes."""

from dataclasses import replace

from golden.light.factors.view_factors import ViewFactors

__all__ = ["METRES", "in_metres"]

METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "in": 0.0254, "ft": 0.3048}
"""Metres of each unit."""


def in_metres(factors: ViewFactors, unit: str) -> ViewFactors:
    """The view factors of a scene in another unit of length than the metre; `settings` name it."""
    if unit == "m":
        return factors
    return replace(factors, area=factors.area * METRES[unit]**2, settings=factors.settings | {"unit": unit})
