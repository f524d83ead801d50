"""One patch as an exact polygon, and how far the page's rounding may move it."""

from fractions import Fraction

from benchmarks.truth.integers import cross, dot, minus, scaled, sign, to_nearest

__all__ = ["SCALE", "ExactPatch"]

# Fraction bits of an exact vertex: those of G and of a matrix entry. A unit of R is 2^ROUNDED of them.
FRACTION, ROUNDED = 24 + 16, 24 + 16 - 22
# N . d / det has the unit of 1/t after a factor of this.
SCALE = Fraction(2) ** (FRACTION - 16)
# Edges, and the diagonal along which a patch may be split; the triples of neighbouring vertices that decide it.
EDGES, DIAGONAL = ((0, 1), (1, 2), (2, 3), (3, 0)), (0, 2)
NEIGHBOURS = ((0, 1, 2), (1, 2, 3), (2, 3, 0), (3, 0, 1))
# What m is off by, in units of its largest component.
MANTISSA = Fraction(1, 2**22)
# Half of the smallest stored 1/t's bound, and the share of a stored 1/t that its truncation removes.
SMALLEST, TRUNCATED = Fraction(1, 2**38), Fraction(1, 2**18)


class ExactPatch:
    """Two triangles in the frame of a frustum, V = M (P - O) without rounding.

    Parameters
    ----------
    corners
        Four points of G.
    matrix, origin
        Those of the frustum.

    Members
    -------
    triangles
        Of the triangles (0, 1, 2) and (0, 2, 3) that are not seen edge-on: the three planes, positive inside, the
        normal N and the determinant of the vertices, positive; 1/t is N . d / det, times `SCALE`.
    is_dropped
        Whether the plane through the rounded vertices passes within two units of the origin.
    turned
        By how much 1/t may be off for the rounding of vertices, as a share of it.
    steepest
        The largest component of the rounded plane's N / V, per unit of a direction.
    """

    def __init__(self, *, corners, matrix, origin):
        offsets = [minus(corner, origin) for corner in corners]
        self.vertices = [tuple(dot(row, offset) for row in matrix) for offset in offsets]
        self.triangles = [triangle for triangle in (self._triangle(0, 1, 2), self._triangle(0, 2, 3)) if triangle]
        self._measure([tuple(to_nearest(component, ROUNDED) for component in vertex) for vertex in self.vertices])
        self._off = [_vertex_error(vertex) for vertex in self.vertices]

    def _triangle(self, *corners):
        a, b, c = (self.vertices[corner] for corner in corners)
        planes = cross(a, b), cross(b, c), cross(c, a)
        determinant = dot(planes[0], c)
        if determinant == 0:
            return None
        planes = [scaled(plane, sign(determinant)) for plane in planes]
        return planes, tuple(map(sum, zip(*planes, strict=True))), abs(determinant)

    def _measure(self, vertices):
        normal = cross(minus(vertices[2], vertices[0]), minus(vertices[3], vertices[1]))
        volume, size = abs(dot(normal, vertices[0])), sum(map(abs, normal))
        self.is_dropped = volume <= 2 * size
        if not self.is_dropped:
            warped = abs(dot(normal, minus(vertices[1], vertices[0])))
            self.turned = (warped + Fraction(size, 2)) / volume
            self.steepest = Fraction(max(map(abs, normal)), volume) * 2 ** (22 - 16)

    def inverse(self, ray) -> Fraction | None:
        """The exact 1/t at which a ray meets the patch, or None."""
        met = [Fraction(dot(normal, ray), determinant) * SCALE for planes, normal, determinant in self.triangles
               if all(dot(plane, ray) >= 0 for plane in planes)]
        return max(met, default=None)

    def depth_bound(self, ray, inverse: Fraction) -> Fraction:
        """How far the stored 1/t may be from the exact one."""
        return inverse * (self.turned + TRUNCATED) + MANTISSA * self.steepest * sum(map(abs, ray)) + SMALLEST

    def edge_share(self, ray) -> Fraction | None:
        """The ray's distance from the nearest edge as a share of what rounding may move that edge by; None above 1."""
        borders = [*EDGES, DIAGONAL] if self._may_split() else EDGES
        return min((share for i, j in borders if (share := self._share(
            (self.vertices[i], self._off[i]), (self.vertices[j], self._off[j]), (ray, 0))) <= 1), default=None)

    def _may_split(self):
        """Whether rounding may leave the triples of neighbouring vertices without a common sign."""
        triples = [[(self.vertices[corner], self._off[corner]) for corner in corners] for corners in NEIGHBOURS]
        signs = {sign(dot(cross(a, b), c)) for (a, _), (b, _), (c, _) in triples}
        return len(signs) > 1 or any(self._share(*triple) <= 1 for triple in triples)

    @staticmethod
    def _share(*points):
        """A determinant of three vectors, each with the error of its components, as a share of its own error."""
        total, (a, b, c) = 0, (vector for vector, _ in points)
        for index in range(3):
            (_, off), (one, first), (other, second) = (points[(index + step) % 3] for step in range(3))
            total += off * (_size(cross(one, other)) + first * _size(other) + second * _size(one))
            total += 2 * off * first * second
        return Fraction(abs(dot(cross(a, b), c))) / total if total else Fraction(2)


def _size(vector):
    return sum(map(abs, vector))


def _vertex_error(vertex):
    """What a component of V' is off by: half a unit of R, and half a unit of V', or one where it stays below 2^17."""
    half = Fraction(2**ROUNDED, 2)
    largest = max(map(abs, vertex)) + half
    unit = Fraction(2) ** ((int(largest) >> ROUNDED).bit_length() - 17 + ROUNDED)
    if unit < 2**ROUNDED * 2:
        return half
    return half + (unit if largest >= (2**17 - Fraction(1, 2)) * unit else unit / 2)
