"""Steps 1 to 4 of docs/fixed-point.md, for one patch in Python's integers."""

from benchmarks.truth.integers import cross, dot, leading, minus, scaled, sign, to_nearest

__all__ = ["DIAGONALS", "EDGES", "RulePatch"]

EDGES = ((0, 1), (1, 2), (2, 3), (3, 0))
DIAGONALS = ((0, 2), (1, 3))


class RulePatch:
    """What rays are tested against.

    Parameters
    ----------
    corners
        Four points of G.
    matrix, origin
        Those of the frustum.

    Members
    -------
    planes, exponents
        n_ij and the exponent of its unit, by (i, j).
    parts
        The polygons that a ray is tested against: orientation and edge planes of each.
    is_dropped
        Whether the plane passes through the origin.
    m, exponent
        m 2^exponent is N / V, per unit of the cube's side.
    """

    def __init__(self, *, corners, matrix, origin):
        vertices = [_vertex(matrix, minus(corner, origin)) for corner in corners]
        directions, exponents = zip(*map(_vertex_direction, vertices), strict=True)
        self.planes = {(i, j): cross(directions[i], directions[j]) for i, j in EDGES + DIAGONALS}
        self.exponents = {(i, j): exponents[i] + exponents[j] for i, j in EDGES + DIAGONALS}
        self.parts = self._parts(directions, is_triangle=tuple(corners[2]) == tuple(corners[3]))
        self._divide(vertices)

    def _parts(self, directions, *, is_triangle):
        def orientation(i, j, k):
            return sign(dot(cross(directions[i], directions[j]), directions[k]))

        n = self.planes
        if is_triangle or len({orientation(i, (i + 1) % 4, (i + 2) % 4) for i in range(4)}) == 1:
            parts = [(orientation(0, 1, 2), [n[edge] for edge in EDGES])]
        else:
            parts = [(orientation(0, 1, 2), [n[0, 1], n[1, 2], scaled(n[0, 2], -1)]),
                     (orientation(0, 2, 3), [n[0, 2], n[2, 3], n[3, 0]])]
        return [part for part in parts if part[0]]

    def _divide(self, vertices):
        normal = cross(minus(vertices[2], vertices[0]), minus(vertices[3], vertices[1]))
        volume = dot(normal, vertices[0])
        self.is_dropped = abs(volume) <= 2 * sum(map(abs, normal))
        if self.is_dropped:
            return
        volume_length, length = abs(volume).bit_length(), max(map(abs, normal)).bit_length()
        reciprocal = min(2**51 // leading(abs(volume), 26, volume_length), 2**26 - 1)
        products = [leading(abs(component), 26, length) * reciprocal for component in normal]
        excess = max(products).bit_length() - 24
        self.m = tuple(sign(component) * sign(volume) * min(to_nearest(product, excess), 2**24 - 1)
                       for component, product in zip(normal, products, strict=True))
        # N has units of 2^-44, V of 2^-66.
        self.exponent = excess + length - volume_length - 51 + 66 - 44


def _vertex(matrix, offset):
    """V in units of 2^-22, from products with 16 + 24 fraction bits."""
    return tuple(to_nearest(dot(row, offset), 16 + 24 - 22) for row in matrix)


def _vertex_direction(vertex):
    """V' and its exponent."""
    exponent = max(map(abs, vertex)).bit_length() - 17
    return tuple(sign(c) * min(to_nearest(abs(c), exponent), 2**17 - 1) for c in vertex), exponent
