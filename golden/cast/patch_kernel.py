"""The test of one ray and one patch of `golden.cast.oracle`, as compiled functions with the same bits."""

import numpy as np

from golden.base.compiled import compiled, inlined

__all__ = ["coordinates", "dominant_axis", "inside", "meet", "position", "sheared"]


@inlined
def dominant_axis(x, y, z):
    """The axis of the largest component, the first of equal ones."""
    if abs(x) >= abs(y):
        return 0 if abs(x) >= abs(z) else 2
    return 1 if abs(y) >= abs(z) else 2


@compiled
def meet(vertices, patch, kx, ky, kz, ox, oy, oz, sx, sy):
    """Whether a ray is inside a patch, and the depth there."""
    return inside(*_corners(vertices, patch, kx, ky, kz, ox, oy, oz, sx, sy))


@compiled
def position(vertices, patch, is_triangle, kx, ky, kz, ox, oy, oz, sx, sy):
    """Bilinear coordinates of a ray's hit on a patch."""
    x0, y0, _, x1, y1, _, x2, y2, _, x3, y3, _ = _corners(vertices, patch, kx, ky, kz, ox, oy, oz, sx, sy)
    return coordinates(x0, y0, x1, y1, x2, y2, x3, y3, is_triangle)


@inlined
def _corners(vertices, patch, kx, ky, kz, ox, oy, oz, sx, sy):
    """A patch's corners, as the ray sees them."""
    x0, y0, z0 = sheared(vertices[patch, 0, kx], vertices[patch, 0, ky], vertices[patch, 0, kz], ox, oy, oz, sx, sy)
    x1, y1, z1 = sheared(vertices[patch, 1, kx], vertices[patch, 1, ky], vertices[patch, 1, kz], ox, oy, oz, sx, sy)
    x2, y2, z2 = sheared(vertices[patch, 2, kx], vertices[patch, 2, ky], vertices[patch, 2, kz], ox, oy, oz, sx, sy)
    x3, y3, z3 = sheared(vertices[patch, 3, kx], vertices[patch, 3, ky], vertices[patch, 3, kz], ox, oy, oz, sx, sy)
    return x0, y0, z0, x1, y1, z1, x2, y2, z2, x3, y3, z3


@inlined
def sheared(x, y, z, ox, oy, oz, sx, sy):
    """A point where the ray is the z axis."""
    depth = z - oz
    return (x - ox) - sx * depth, (y - oy) - sy * depth, depth


@inlined
def inside(x0, y0, z0, x1, y1, z1, x2, y2, z2, x3, y3, z3):
    """Whether the z axis is inside a patch, and the depth there."""
    e01, e12, e20 = x0 * y1 - y0 * x1, x1 * y2 - y1 * x2, x2 * y0 - y2 * x0
    e23, e30, e02 = x2 * y3 - y2 * x3, x3 * y0 - y3 * x0, -e20
    low, high = min(e01, e12, e20), max(e01, e12, e20)
    first = ((low >= 0) | (high <= 0)) & (low != high)
    # Of a triangle, whose last corners are one, this half is empty.
    low, high = min(e23, e30, e02), max(e23, e30, e02)
    second = ((low >= 0) | (high <= 0)) & (low != high)
    above = e12 * z0 + e20 * z1 + e01 * z2 if first else e23 * z0 + e30 * z2 + e02 * z3
    return first | second, above / (e12 + e20 + e01 if first else e23 + e30 + e02)


@inlined
def coordinates(x0, y0, x1, y1, x2, y2, x3, y3, is_triangle):
    """Bilinear coordinates where the z axis meets a patch."""
    e01, e12, e20 = x0 * y1 - y0 * x1, x1 * y2 - y1 * x2, x2 * y0 - y2 * x0
    total = e01 + e12 + e20
    bx, by, cx, cy = x1 - x0, y1 - y0, x3 - x0, y3 - y0
    dx, dy = x2 - x3 - bx, y2 - y3 - by
    # Of a quadrilateral v is the root of a x^2 + b x + c nearest to the middle of [0, 1], without cancellation.
    a, b, c = cx * dy - cy * dx, (x0 * dy - y0 * dx) + (cx * by - cy * bx), x0 * by - y0 * bx
    q = -0.5 * (b + np.copysign(np.sqrt(max(b * b - 4 * a * c, 0.0)), b))
    far, near = (e01 if is_triangle else q) / (total if is_triangle else a), c / q
    v = far if is_triangle | (_off_middle(far) < _off_middle(near)) else near
    along_x, along_y = bx + dx * v, by + dy * v
    u = ((e20 if is_triangle else -((x0 + cx * v) * along_x + (y0 + cy * v) * along_y))
         / (total - e01 if is_triangle else along_x * along_x + along_y * along_y))
    return _share(u), _share(v)


@inlined
def _off_middle(value):
    """Distance from 0.5; infinity of what is not finite."""
    return abs(value - 0.5) if abs(value) < np.inf else np.inf


@inlined
def _share(value):
    """A value clipped to [0, 1]; what is not finite is 0."""
    return min(max(value, 0.0), 1.0) + 0.0 if abs(value) < np.inf else 0.0
