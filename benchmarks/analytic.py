"""Form factors of unoccluded polygons in closed form: the reference of casting."""

import numpy as np

from golden.base.errors import InputError

__all__ = ["point_to_polygon", "polygon_to_polygon"]

# A vertex whose height over a receiver's horizon is below this share of its distance counts as on the horizon.
_HORIZON = 1e-13

# Points times edges per block, such that they stay in a core's cache.
_BLOCK = 1 << 14

# Gauss points along a cell's side: the difference of the coarse and the fine rule estimates the error.
_COARSE, _FINE = 4, 7

# Most halvings of a cell (its share of the area is then 4^-depth).
_DEPTH = 40


def point_to_polygon(points, normals, polygons) -> np.ndarray:
    """Form factors from small elements to polygons, without occlusion, by Lambert's formula.

    Each polygon is clipped at each element's horizon. Along the horizon the clipped polygon is closed by one edge,
    since a convex polygon leaves the upper half-space once.

    Parameters
    ----------
    points, normals
        P x 3 positions and unit normals of the elements.
    polygons
        K x n x 3 vertices of convex planar polygons, counter-clockwise from the front; vertices may repeat.

    Returns
    -------
    P x K: positive where the element sees the polygon's front, negative where it sees its back. An element in the
    polygon's own plane sees none of it.

    Raises
    ------
    InputError
        Shapes do not match or a value is not finite.

    Source: Lambert 1760, Photometria; Sparrow and Cess, Radiation Heat Transfer (contour form).
    """
    points = _array("Points", points, (None, 3))
    normals = _array("Normals", normals, (len(points), 3))
    polygons = _array("Polygons", polygons, (None, None, 3))
    step = max(1, _BLOCK // max(1, polygons.shape[0] * polygons.shape[1]))
    blocks = [_lambert(points[at:at + step], normals[at:at + step], polygons) for at in range(0, len(points), step)]
    return np.concatenate(blocks) if blocks else np.zeros((0, len(polygons)))


def polygon_to_polygon(source, target, *, tolerance: float = 1e-9) -> float:
    """Form factor from one polygon's front to another's, averaged over the first, without occlusion.

    The part of the source behind the target's plane is cut off first, so the integrand is smooth except where the
    polygons touch. There the cells of the integration are halved until their estimated errors sum to less than
    ``tolerance``.

    Parameters
    ----------
    source, target
        n x 3 and m x 3 vertices of convex planar polygons, counter-clockwise from the front.
    tolerance
        Bound of the summed error estimates, at least 1e-12.

    Raises
    ------
    InputError
        Fewer than three vertices, a value that is not finite, no area, or a tolerance out of range.
    """
    source, target = (_array(name, value, (None, 3)) for name, value in (("Source", source), ("Target", target)))
    if not 1e-12 <= tolerance < 1:
        raise InputError(f"form factor: Tolerance must be 1e-12 to 1, not {tolerance!r}")
    vectors = [_area_vector(name, polygon) for name, polygon in (("Source", source), ("Target", target))]
    normal, facing = (vector / np.linalg.norm(vector) for vector in vectors)
    receiving = _clip(source, target[0], facing)
    if len(receiving) < 3:
        return 0.0
    centre = np.broadcast_to(receiving.mean(axis=0), receiving.shape)
    cells = np.stack([centre, receiving, np.roll(receiving, -1, axis=0)], axis=1)
    total = 0.0
    for depth in range(_DEPTH):
        fine, coarse = (_cell_integrals(cells, normal, target, order) for order in (_FINE, _COARSE))
        error = np.abs(fine - coarse) / np.linalg.norm(vectors[0])
        order = np.argsort(error, kind="stable")
        settled = np.cumsum(error[order]) <= tolerance / 2 ** (depth + 1)
        total += fine[order[settled]].sum()
        cells = _quarter(cells[order[~settled]])
        if not len(cells):
            break
    return float(total / np.linalg.norm(vectors[0]))


def _lambert(points, normals, polygons):
    """`point_to_polygon` of one block; vectors have their components first."""
    tail = polygons.transpose(2, 0, 1)[:, None] - points.T[:, :, None, None]
    axis = normals.T[:, :, None, None]
    height = _dot(tail, axis)
    height[np.abs(height) <= _HORIZON * np.sqrt(_dot(tail, tail))] = 0.0
    head, after = np.roll(tail, -1, axis=-1), np.roll(height, -1, axis=-1)
    if (height >= 0).all():
        contour = _edge_terms(tail, head, axis).sum(axis=-1)
        return np.where((height > 0).any(axis=-1), contour, 0.0) / (-2 * np.pi)
    leaves, enters = (height > 0) & (after <= 0), (height <= 0) & (after > 0)
    share = np.divide(height, height - after, out=np.zeros_like(height), where=leaves | enters)
    crossing = tail + share * (head - tail)
    terms = _edge_terms(np.where(enters, crossing, tail), np.where(leaves, crossing, head), axis)
    contour = np.where((height > 0) | (after > 0), terms, 0.0).sum(axis=-1)
    last, first = (np.where(mask, crossing, 0.0).sum(axis=-1) for mask in (leaves, enters))
    return (contour + _edge_terms(last, first, axis[..., 0])) / (-2 * np.pi)


def _edge_terms(tail, head, axis):
    """Angle under which an edge is seen times the cosine of its plane's normal with the element's."""
    cross = np.stack([tail[1] * head[2] - tail[2] * head[1], tail[2] * head[0] - tail[0] * head[2],
                      tail[0] * head[1] - tail[1] * head[0]])
    sine = np.sqrt(_dot(cross, cross))
    angle = np.arctan2(sine, _dot(tail, head))
    return angle * np.divide(_dot(cross, axis), sine, out=np.zeros_like(sine), where=sine > 0)


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cell_integrals(cells, normal, polygon, order):
    """Integrals of the form factor to ``polygon`` over triangles (C x 3 x 3), by collapsed Gauss points."""
    knots, gauss = np.polynomial.legendre.leggauss(order)
    knots, gauss = (knots + 1) / 2, gauss / 2
    u, v = (grid.ravel() for grid in np.meshgrid(knots, knots, indexing="ij"))
    weights = np.outer(gauss * knots, gauss).ravel()
    corners = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    points = np.einsum("qk,ckx->cqx", corners, cells).reshape(-1, 3)
    seen = point_to_polygon(points, np.broadcast_to(normal, points.shape), polygon[None])
    twice = np.linalg.norm(np.cross(cells[:, 1] - cells[:, 0], cells[:, 2] - cells[:, 0]), axis=1)
    return twice * (seen.reshape(len(cells), -1) @ weights)


def _quarter(cells):
    """Four triangles for each, cut at the middles of the sides."""
    a, b, c = cells.transpose(1, 0, 2)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    return np.concatenate([np.stack(parts, axis=1) for parts in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])


def _clip(polygon, point, normal):
    """The part of a convex polygon on the side of a plane to which its normal points."""
    following = np.roll(polygon, -1, axis=0)
    height, after = (polygon - point) @ normal, (following - point) @ normal
    kept = []
    for here, there, low, high in zip(polygon, following, height, after, strict=True):
        if low >= 0:
            kept.append(here)
        if low * high < 0:
            kept.append(here + low / (low - high) * (there - here))
    return np.array(kept).reshape(-1, 3)


def _area_vector(name, polygon):
    if len(polygon) < 3:
        raise InputError(f"form factor: {name} must have at least three vertices, not {len(polygon)}")
    arms = polygon - polygon[0]
    vector = 0.5 * np.cross(arms[1:-1], arms[2:]).sum(axis=0)
    if not np.linalg.norm(vector) > 0:
        raise InputError(f"form factor: {name} must have an area, not {polygon.tolist()!r}")
    return vector


def _array(name, value, shape):
    value = np.asarray(value, dtype=np.float64)
    if value.ndim != len(shape) or any(
            required not in (None, got) for required, got in zip(shape, value.shape, strict=True)):
        requirement = " x ".join("any" if size is None else str(size) for size in shape)
        raise InputError(f"form factor: {name} must be {requirement}, not {value.shape!r}")
    if not np.isfinite(value).all():
        raise InputError(f"form factor: {name} must be finite")
    return value
