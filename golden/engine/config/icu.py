"""Parameters of the intersection computation unit."""

from dataclasses import dataclass

from golden.engine.config.checks import check_power_of_two, check_range
from golden.engine.lib.fixed import Format, unsigned

__all__ = ["Icu"]


@dataclass(frozen=True, kw_only=True)
class Icu:
    """Parameters of the intersection computation unit (ICU).

    Parameters
    ----------
    rays
        Rays that the ray memory of one cluster holds; a power of two, 64 to 2^22.
    side_bits
        A frustum has at most 2^b columns and 2^b rows; 6 to 16.
    patch_bits
        A scene has at most 2^b patches; 8 to 24.
    tile_bits
        A word of the settle map holds the codes of 2^b x 2^b rays; 1 to 3.
    slots
        Patches in flight between the start of their setup and the issue of their last ray; a power of two, 16 to 128.
        Setup accepts a patch every four cycles: a quarter of its latency in slots sustains that rate. Hardware only.
    generation_bits
        Bits of the generation tags that invalidate a ray memory in one cycle; after 2^b - 1 frusta it is cleared word
        by word; 1 to 16. Hardware only.
    product_registers
        Pipeline registers of each multiplier; 1 to 3. Hardware only.
    angle_bits
        Bits of an angle; 2^b is a full turn; 18 to 24.
    cordic_stages
        Steps of each CORDIC; 8 to 20.
    cordic_guard
        Fraction bits that the CORDIC data path adds to V'; 0 to 8.
    sagitta_polar_bits, sagitta_span_bits
        Address bits of the sagitta table: how far an edge of a patch rises above its ends, by the lower polar angle and
        by the azimuths between the ends; 3 to 8 each.
    uv_bits
        Bits of u and of v; 0 to 12. With 0 the hardware does not compute them.
    uv_guard
        Guard bits of the subdivision, beside the 2 x ``uv_bits`` that its halvings consume; 0 to 12.
    shadow_bits
        A shadow frustum has a list of at most 2^b rays; 0 to 14, at most ``side_bits`` + 6. With 0 the machine casts
        none, and has nothing for them.
    settle_bits, settle_fraction
        Bits of a settle code, 4 to 12, and fraction bits among them, 1 to ``settle_bits`` - 2.
    """

    rays: int = 1 << 18
    side_bits: int = 12
    patch_bits: int = 16
    tile_bits: int = 2
    slots: int = 64
    generation_bits: int = 4
    product_registers: int = 2
    angle_bits: int = 24
    cordic_stages: int = 16
    cordic_guard: int = 6
    sagitta_polar_bits: int = 5
    sagitta_span_bits: int = 6
    uv_bits: int = 8
    uv_guard: int = 8
    shadow_bits: int = 0
    settle_bits: int = 8
    settle_fraction: int = 5

    def __post_init__(self):
        check_power_of_two("icu", "rays", self.rays, 64, 1 << 22)
        check_power_of_two("icu", "slots", self.slots, 16, 128)
        for name, low, high in (("side_bits", 6, 16), ("patch_bits", 8, 24), ("tile_bits", 1, 3),
                                ("generation_bits", 1, 16), ("product_registers", 1, 3),
                                ("angle_bits", 18, 24), ("cordic_stages", 8, 20), ("cordic_guard", 0, 8),
                                ("sagitta_polar_bits", 3, 8), ("sagitta_span_bits", 3, 8), ("uv_bits", 0, 12),
                                ("uv_guard", 0, 12), ("settle_bits", 4, 12),
                                ("shadow_bits", 0, min(14, self.side_bits + 6)),
                                ("settle_fraction", 1, self.settle_bits - 2)):
            check_range("icu", name, getattr(self, name), low, high)

    @property
    def ray_bits(self) -> int:
        """Address bits of the ray memory."""
        return self.rays.bit_length() - 1

    @property
    def slot_bits(self) -> int:
        """Bits of a slot's number."""
        return self.slots.bit_length() - 1

    @property
    def listed_rays(self) -> int:
        """Most rays of a shadow frustum's list."""
        return 1 << self.shadow_bits if self.shadow_bits else 0

    @property
    def uv(self) -> Format:
        """Parameters u and v of a hit: steps of the patch's lattice."""
        return unsigned(0, self.uv_bits)

    @property
    def settle(self) -> Format:
        """Settle codes."""
        return unsigned(self.settle_bits, 0)
