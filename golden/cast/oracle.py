"""The oracle: intersections of rays and patches in float64, the reference for rounding.

A shear maps the ray to the z axis: vertex ``V`` of a patch becomes
``(V_x - s_x V_z, V_y - s_y V_z)``, with z the ray's dominant axis and ``V`` relative to the ray's origin. The ray meets
a triangle where the three edge functions ``e_ij = x_i y_j - y_i x_j`` have no two opposite signs, and a quadrilateral
where it meets one of the triangles (0, 1, 2) and (0, 2, 3).

*Watertight*: a shared vertex gives the same two numbers for both patches, and the sign of a difference of two rounded
products is never the opposite of the true one. So a ray between two neighbours is inside at least one of them, edges
and vertices included.

Source: the edge planes of docs/exactness.md as edge functions, in float64 and for rays of any origin.
"""

from functools import cached_property

import numpy as np

from golden.base.errors import InputError
from golden.cast.rays import Rays
from golden.scene.scene import Scene

__all__ = ["Oracle", "ShearedRays"]

# A hit must be this share of the scene's size away from the origin: far more than rounding moves a point that was
# computed on a surface, far less than any feature of a scene.
NEAREST_SHARE = 2.0**-30
# The same in units of the last place of the scene's coordinates, for scenes far from the origin.
NEAREST_PLACES = 4
# Sizes of scenes for which products of four coordinates neither overflow nor vanish.
SMALLEST, LARGEST = 2.0**-200, 2.0**200
# Farthest coordinate in sizes of the scene: farther away float64 keeps less than 2^-24 of the scene's size apart.
FARTHEST = 2.0**28
# Farthest origin of a ray from the scene box in its sizes: there rounding reaches the margin of the cells.
FARTHEST_RAY = 2.0**18


class ShearedRays:
    """Rays with the dominant axis, the shear, and the origin in that axis' frame.

    Arrays are components first (3 x R), so that each component is contiguous.
    """

    def __init__(self, rays: Rays, tmin: np.ndarray):
        direction = rays.direction
        self.axis = np.argmax(np.abs(direction), axis=1)
        order = (self.axis[:, None] + np.array([1, 2, 0])) % 3
        along = np.take_along_axis(direction, order, axis=1)
        self.origin = np.ascontiguousarray(np.take_along_axis(rays.origin, order, axis=1).T)
        self.shear = np.ascontiguousarray((along[:, :2] / along[:, 2:]).T)
        self.scale = 1 / along[:, 2]
        self.source, self.target = rays.source, rays.target
        self.tmin = tmin


class Oracle:
    """Ray-patch tests of one scene.

    Parameters
    ----------
    scene
        The patches.

    Members
    -------
    nearest
        Least distance of a hit from a ray's origin, in scene units.

    Raises
    ------
    InputError
        Float64 does not resolve the scene: it is too small, too large, or too far from the origin for its size.
    """

    def __init__(self, scene: Scene):
        if not SMALLEST <= scene.size <= LARGEST:
            raise InputError(f"scene {scene.name!r}: Size must be {SMALLEST:.0e} to {LARGEST:.0e}, not {scene.size!r}")
        far = float(np.abs(scene.bounds).max())
        if far > FARTHEST * scene.size:
            raise InputError(f"scene {scene.name!r}: Coordinates must be at most {FARTHEST:.0e} times its size "
                             f"{scene.size:.6g}, not {far:.6g}; move it to the origin")
        self.nearest = max(NEAREST_SHARE * scene.size, NEAREST_PLACES * float(np.spacing(far)))
        self.scene = scene
        self._count = len(scene)

    @cached_property
    def _vertices(self):
        """Column a * N + i: the components of patch i's vertices with axis a as the last one."""
        return np.concatenate(
            [np.roll(self.scene.vertices, -1 - axis, axis=2).reshape(-1, 12).T for axis in range(3)], axis=1)

    def check(self, rays: Rays) -> None:
        """Refuse rays that float64 does not resolve.

        Raises
        ------
        InputError
            An origin is farther than 2^18 of the scene's size from the scene box.
        """
        if len(rays) == 0:
            return
        lower, upper = self.scene.bounds + np.array([[-1], [1]]) * FARTHEST_RAY * self.scene.size
        # A column is far faster than an axis of three.
        if any(column.min() < low or column.max() > high
               for column, low, high in zip(rays.origin.T, lower, upper, strict=True)):
            bad = np.flatnonzero(((rays.origin < lower) | (rays.origin > upper)).any(axis=1))[0]
            raise InputError(f"rays: Origin of ray {bad} must be within {FARTHEST_RAY:.0f} of the scene's size of the "
                             f"scene, not {rays.origin[bad]!r}")

    def sheared(self, rays: Rays) -> ShearedRays:
        """The rays as `hits` takes them; see `check`."""
        self.check(rays)
        return ShearedRays(rays, self.tmin(rays.direction))

    def tmin(self, direction: np.ndarray) -> np.ndarray:
        """The least t of hits along directions, R x 3."""
        x, y, z = direction.T
        return self.nearest / np.sqrt(x * x + y * y + z * z)

    def hits(self, rays: ShearedRays, ray: np.ndarray, patch: np.ndarray, tmax: np.ndarray):
        """Which of the K pairs ``(ray[k], patch[k])`` meet at ``tmin < t < tmax[k]``.

        Returns
        -------
        tuple
            The numbers k of the pairs that hit, and their t.
        """
        x, y, z = self._project(rays, ray, self._columns(rays, ray, patch))
        pair, t = _meet(x, y, z)
        return self._accept(rays, ray[pair], patch[pair], t, tmax[pair], pair)

    def all_hits(self, rays: ShearedRays, ray: np.ndarray):
        """Hits of every patch with every one of the rays ``ray``, which share their dominant axis.

        Returns
        -------
        tuple
            Ray, patch and t of each hit, without a limit on t but ``tmin``.
        """
        columns = slice(rays.axis[ray[0]] * self._count, (rays.axis[ray[0]] + 1) * self._count)
        x, y, z = self._project(rays, ray[:, None], [component[columns] for component in self._vertices])
        pair, t = _meet(x, y, z)
        row, patch = np.divmod(pair, self._count)
        row = ray[row]
        keep, t = self._accept(rays, row, patch, t, np.inf, np.arange(len(pair)))
        return row[keep], patch[keep], t

    def uv(self, rays: ShearedRays, ray: np.ndarray, patch: np.ndarray):
        """Bilinear coordinates (u, v) at which rays meet the patches that they are known to hit.

        With vertices a, a + b, a + b + c + d, a + c around the ray the point is ``a + b u + c v + d u v = 0``. A
        triangle is the quadrilateral whose last two vertices are one: there v is the barycentric coordinate of that
        vertex, at which u is undefined and given as 0.
        """
        x, y, _ = self._project(rays, ray, self._columns(rays, ray, patch))
        e01, e12, e20, _, _ = _edges(x, y)
        a, b, c = (x[0], y[0]), (x[1] - x[0], y[1] - y[0]), (x[3] - x[0], y[3] - y[0])
        d = (x[2] - x[3] - b[0], y[2] - y[3] - b[1])
        with np.errstate(divide="ignore", invalid="ignore"):
            v = _unit_root(_cross(c, d), _cross(a, d) + _cross(c, b), _cross(a, b))
            along = (b[0] + d[0] * v, b[1] + d[1] * v)
            u = -((a[0] + c[0] * v) * along[0] + (a[1] + c[1] * v) * along[1]) / (along[0]**2 + along[1]**2)
            total = e01 + e12 + e20
            triangle = self.scene.is_triangle[patch]
            v = np.where(triangle, e01 / total, v)
            u = np.where(triangle, e20 / (total - e01), u)
        # A sum with 0 is never the negative zero.
        return tuple(np.clip(np.nan_to_num(value, posinf=0, neginf=0), 0, 1) + 0.0 for value in (u, v))

    def _columns(self, rays, ray, patch):
        """The twelve vertex components of each pair's patch in its ray's frame."""
        column = rays.axis[ray] * self._count + patch
        return [component.take(column) for component in self._vertices]

    @staticmethod
    def _project(rays, ray, vertices):
        """Sheared x, y and relative z of the four vertices."""
        origin = [component[ray] for component in rays.origin]
        shear = [component[ray] for component in rays.shear]
        z = [vertices[3 * corner + 2] - origin[2] for corner in range(4)]
        x, y = ([(vertices[3 * corner + axis] - origin[axis]) - shear[axis] * z[corner] for corner in range(4)]
                for axis in range(2))
        return x, y, z

    def _accept(self, rays, ray, patch, depth, tmax, pair):
        """The hits ``pair`` in front of the ray, nearer than ``tmax`` and not on its source."""
        t = depth * rays.scale[ray]
        surface = self.scene.surface[patch]
        keep = (t > rays.tmin[ray]) & (t < tmax) & (surface != rays.source[ray]) & (surface != rays.target[ray])
        return pair[keep], t[keep]


def _meet(x, y, z):
    """Flat indices of the pairs that meet, and z there: the vertices' mean, weighted by the opposite edge functions."""
    e01, e12, e20, e23, e30 = edges = _edges(x, y)
    first, second = _inside(edges)
    pair = np.flatnonzero(first | second)
    e01, e12, e20, e23, e30, first = (edge.reshape(-1)[pair] for edge in (e01, e12, e20, e23, e30, first))
    z = [component.reshape(-1)[pair] for component in np.broadcast_arrays(*z)]
    # A ray inside both triangles passes through the diagonal, and both give the same depth.
    weights = (np.where(first, e12, e23), np.where(first, e20, 0.0),
               np.where(first, e01, e30), np.where(first, 0.0, -e20))
    total = weights[0] + weights[1] + weights[2] + weights[3]
    depth = weights[0] * z[0] + weights[1] * z[1] + weights[2] * z[2] + weights[3] * z[3]
    return pair, depth / total


def _cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def _edges(x, y):
    """Edge functions 01, 12, 20, 23, 30."""
    return [x[i] * y[j] - y[i] * x[j] for i, j in ((0, 1), (1, 2), (2, 0), (2, 3), (3, 0))]


def _inside(edges):
    """Whether the ray is in the triangles (0, 1, 2) and (0, 2, 3); one seen exactly edge-on has no inside."""
    e01, e12, e20, e23, e30 = edges
    low, high = np.minimum(e01, e12), np.maximum(e01, e12)
    np.minimum(low, e20, out=low)
    np.maximum(high, e20, out=high)
    first = ((low >= 0) | (high <= 0)) & (low != high)
    low, high = np.minimum(e23, e30), np.maximum(e23, e30)
    np.minimum(low, -e20, out=low)
    np.maximum(high, -e20, out=high)
    return first, ((low >= 0) | (high <= 0)) & (low != high)


def _unit_root(a, b, c):
    """The root of ``a x^2 + b x + c`` nearest to the middle of [0, 1], without cancellation."""
    q = -0.5 * (b + np.copysign(np.sqrt(np.maximum(b * b - 4 * a * c, 0)), b))
    far, near = q / a, c / q
    far, near = np.where(np.isfinite(far), far, np.inf), np.where(np.isfinite(near), near, np.inf)
    return np.where(np.abs(far - 0.5) < np.abs(near - 0.5), far, near)
