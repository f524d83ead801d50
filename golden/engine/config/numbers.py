"""Widths of numbers."""

from dataclasses import dataclass

from golden.base.errors import InputError
from golden.engine.config.checks import check_range
from golden.engine.lib.fixed import Format, signed, unsigned

__all__ = ["Numbers"]


@dataclass(frozen=True, kw_only=True)
class Numbers:
    """Widths of the numbers that several blocks share. Each width is derived in docs/exactness.md.

    Parameters
    ----------
    scene_bits
        Bits of a scene (G) coordinate, unsigned 0.b of the unit cube; 12 to 24.
    vector_fraction
        Fraction bits of a vertex in the R frame, signed 1.b; 10 to 22, at most ``scene_bits``.
    direction_fraction
        Fraction bits of ray directions and matrix entries, signed 1.b; 8 to 16, so that 18-bit multipliers hold them.
    vertex_bits
        Magnitude bits of a normalised vertex direction V'; 8 to 17, so that an edge plane is two limbs of 18 bits. With
        8 it is one limb.
    mantissa_bits
        Magnitude bits of the plane factor m = N/V; 18 to 24. 18 bits are too few at grazing angles.
    exponent_bits, fraction_bits
        Bits of the exponent and of the fraction of the stored inverse distance 1/t; 5 to 7 and 8 to 24.
    """

    scene_bits: int = 24
    vector_fraction: int = 22
    direction_fraction: int = 16
    vertex_bits: int = 17
    mantissa_bits: int = 24
    exponent_bits: int = 6
    fraction_bits: int = 18

    def __post_init__(self):
        for name, low, high in (("scene_bits", 12, 24), ("vector_fraction", 10, 22), ("direction_fraction", 8, 16),
                                ("vertex_bits", 8, 17), ("mantissa_bits", 18, 24), ("exponent_bits", 5, 7),
                                ("fraction_bits", 8, 24)):
            check_range("numbers", name, getattr(self, name), low, high)
        if self.vector_fraction > self.scene_bits:
            raise InputError("configuration: Vector fraction (numbers.vector_fraction) must be at most "
                             f"numbers.scene_bits ({self.scene_bits}), not {self.vector_fraction!r}")

    @property
    def scene(self) -> Format:
        """Scene (G) coordinates."""
        return unsigned(0, self.scene_bits)

    @property
    def offset(self) -> Format:
        """A vertex relative to the frustum's origin, before the rotation."""
        return signed(0, self.scene_bits)

    @property
    def vector(self) -> Format:
        """Vertices in the R frame."""
        return signed(1, self.vector_fraction)

    @property
    def direction(self) -> Format:
        """Ray directions, ray tables and matrix entries."""
        return signed(1, self.direction_fraction)

    @property
    def vertex(self) -> Format:
        """Components of V'."""
        return signed(self.vertex_bits, 0)

    @property
    def edge_plane(self) -> Format:
        """Components of V'_i x V'_j: two products of ``vertex_bits`` magnitudes."""
        return signed(2 * self.vertex_bits + 1, 0)

    @property
    def edge_distance(self) -> Format:
        """n_ij . d: edge plane times ray direction, a sum of three products."""
        return signed(2 * self.vertex_bits + self.direction_fraction + 3, 0)

    @property
    def plane_normal(self) -> Format:
        """Plane normal N, the cross product of two differences of vertices."""
        return signed(2 * (self.vector_fraction + 2) + 1, 0)

    @property
    def mantissa(self) -> Format:
        """Components of m, in units of its exponent."""
        return signed(self.mantissa_bits, 0)

    @property
    def inverse(self) -> Format:
        """The stored inverse distance as one integer: exponent, then fraction."""
        return unsigned(self.exponent_bits + self.fraction_bits, 0)

    @property
    def inverse_top(self) -> int:
        """Largest exponent of a stored inverse distance: one unit of the R frame is 2^-``vector_fraction`` long."""
        return self.vector_fraction + 2

    @property
    def inverse_bias(self) -> int:
        """An inverse distance is 1.f x 2^(exponent - bias)."""
        return (1 << self.exponent_bits) - 1 - self.inverse_top
