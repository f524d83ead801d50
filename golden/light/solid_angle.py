"""Directions drawn uniformly from the solid angle of a triangle."""

import numpy as np

__all__ = ["direction_to_triangle", "solid_angle"]


def solid_angle(corners: np.ndarray) -> np.ndarray:
    """Solid angles of K triangles, K x 3 x 3, seen from the origin.

    Source: Van Oosterom and Strackee 1983, The solid angle of a plane triangle.
    """
    a, b, c = np.moveaxis(_unit(corners), 1, 0)
    volume = np.abs(_dot(a, np.cross(b, c)))
    return 2 * np.arctan2(volume, 1 + _dot(a, b) + _dot(b, c) + _dot(c, a))


def direction_to_triangle(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Unit vectors from the origin into triangles: an area-preserving map of the unit square.

    Parameters
    ----------
    corners
        K x 3 x 3; no solid angle may be zero.
    x, y
        K each, 0 to 1.

    Source: Arvo 1995, Stratified sampling of spherical triangles.
    """
    a, b, c = np.moveaxis(_unit(corners), 1, 0)
    # The angle at a between the planes of its edges; its sine and cosine come without a division by the edges' lengths.
    across_b, across_c = np.cross(a, b), np.cross(a, c)
    sine = np.linalg.norm(np.cross(across_b, across_c), axis=1)
    cosine = _dot(across_b, across_c)
    angle = np.arctan2(sine, cosine)
    sine, cosine = np.sin(angle), np.cos(angle)
    part = x * solid_angle(corners) - angle
    s, t = np.sin(part), np.cos(part)
    p, q = t - cosine, s + sine * _dot(a, b)
    along = ((q * t - p * s) * cosine - q) / ((q * s + p * t) * sine)
    moved = _arc(a, c, np.clip(along, -1, 1))
    return _arc(b, moved, 1 - y * (1 - _dot(moved, b)))


def _arc(start, end, cosine):
    """Unit vectors on the arcs from ``start`` towards ``end`` at an angle of the given cosine."""
    square = end - _dot(end, start)[:, None] * start
    square /= np.maximum(np.linalg.norm(square, axis=1, keepdims=True), 1e-300)
    return cosine[:, None] * start + np.sqrt(np.maximum(1 - cosine**2, 0))[:, None] * square


def _unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def _dot(a, b):
    return np.einsum("kj,kj->k", a, b)
