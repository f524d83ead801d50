"""Closed forms from Howell's catalogue of radiation configuration factors, by their numbers there."""

import numpy as np

__all__ = ["b_4", "b_5", "c_11", "c_14", "c_41", "c_91", "c_92"]


def c_11(x, y):
    """Equal, parallel, directly opposed rectangles of sides ``x`` and ``y`` at distance 1."""
    p, q = np.sqrt(1 + x * x), np.sqrt(1 + y * y)
    inner = np.log(p * q / np.sqrt(1 + x * x + y * y)) + x * q * np.arctan(x / q) + y * p * np.arctan(y / p)
    return 2 / (np.pi * x * y) * (inner - x * np.arctan(x) - y * np.arctan(y))


def c_14(w, h):
    """From a rectangle 1 x ``w`` to one 1 x ``h`` at right angles that shares the edge of length 1."""
    a, b = w * w, h * h
    logs = (np.log((1 + a) * (1 + b) / (1 + a + b)) + a * np.log(a * (1 + a + b) / ((1 + a) * (a + b)))
            + b * np.log(b * (1 + a + b) / ((1 + b) * (a + b))))
    diagonal = np.sqrt(a + b)
    return (w * np.arctan(1 / w) + h * np.arctan(1 / h) - diagonal * np.arctan(1 / diagonal) + logs / 4) / (np.pi * w)


def b_4(a, b):
    """From an element to a parallel rectangle ``a`` x ``b`` at distance 1 whose corner is on the element's normal."""
    p, q = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
    return (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / (2 * np.pi)


def b_5(a, b, c):
    """From an element to a rectangle at right angles, height ``a``, width ``b``, at distance ``c``."""
    x, y = a / b, c / b
    distance = np.sqrt(x * x + y * y)
    return (np.arctan(1 / y) - y / distance * np.arctan(1 / distance)) / (2 * np.pi)


def c_41(r1, r2):
    """From a disc of radius ``r1`` to a parallel, coaxial one of radius ``r2`` at distance 1."""
    s = 1 + (1 + r2 * r2) / (r1 * r1)
    return (s - np.sqrt(s * s - 4 * (r2 / r1) ** 2)) / 2


def c_91(r, h):
    """From the inside of a cylinder of radius ``r`` to a coaxial one of radius 1 within it, both of height ``h``."""
    a, b = h * h + r * r - 1, h * h - r * r + 1
    return (1 - (np.arccos(b / a) - (np.sqrt((a + 2)**2 - 4 * r * r) * np.arccos(b / (r * a)) + b * np.arcsin(1 / r)
                                     - np.pi * a / 2) / (2 * h)) / np.pi) / r


def c_92(r, h):
    """From the inside of a cylinder of radius ``r`` to itself, around one of radius 1, both of height ``h``."""
    root, square = np.sqrt(4 * r * r + h * h) / h, r * r - 1
    bent = root * np.arcsin((4 * square + (h / r)**2 * (r * r - 2)) / (h * h + 4 * square))
    return (1 - 1 / r + 2 / (np.pi * r) * np.arctan(2 * np.sqrt(square) / h)
            - h / (2 * np.pi * r) * (bent - np.arcsin((r * r - 2) / (r * r)) + np.pi / 2 * (root - 1)))
