"""Elementary functions to more than 24 digits: references for tables and bounds that golden computes in float64."""

from decimal import Decimal
from functools import cache

__all__ = ["asin", "atan", "ceil", "cos", "nearest", "pi", "sin", "tan"]


@cache
def pi() -> Decimal:
    """Machin's formula."""
    return 16 * atan(1 / Decimal(5)) - 4 * atan(1 / Decimal(239))


def atan(value) -> Decimal:
    """The angle of a tangent, by its series after three halvings."""
    value = Decimal(value)
    for _ in range(3):
        value = value / (1 + (1 + value * value).sqrt())
    return 8 * _series(value, lambda n: Decimal((-1) ** n) / (2 * n + 1))


def asin(value) -> Decimal:
    """The angle of a sine, from -1 to 1."""
    value = Decimal(value)
    return pi() / 2 * value if abs(value) == 1 else atan(value / (1 - value * value).sqrt())


@cache
def sin(value: Decimal) -> Decimal:
    """The sine of an angle of up to a turn."""
    total, term, n = Decimal(0), Decimal(value), 1
    while abs(term) > Decimal(10) ** -40:
        total, term, n = total + term, -term * value * value / ((n + 1) * (n + 2)), n + 2
    return total


def cos(value: Decimal) -> Decimal:
    """The cosine of an angle of up to a turn."""
    return 1 - 2 * sin(value / 2) ** 2


def tan(value: Decimal) -> Decimal:
    """The tangent of an angle below a quarter turn."""
    return sin(value) / cos(value)


def nearest(value: Decimal) -> int:
    """The nearest integer, half away from zero."""
    return int(abs(value) + Decimal("0.5")) * (1 if value >= 0 else -1)


def ceil(value: Decimal) -> int:
    """The smallest integer that is not below the value."""
    return -int(-value // 1) if value == value // 1 else int(value // 1) + (value > 0)


def _series(value, coefficient):
    """Sum of coefficient(n) value^(2 n + 1)."""
    total, power, n = Decimal(0), value, 0
    while abs(power) > Decimal(10) ** -40:
        total, power, n = total + coefficient(n) * power, power * value * value, n + 1
    return total
