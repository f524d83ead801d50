"""Configurations that testbenches run with."""

from golden.engine.config import PRESETS, Config

__all__ = ["CONFIGURATIONS", "DEPTHS", "config_of"]

# All widths as the machine's, and all of them narrow.
CONFIGURATIONS = {
    "default": {},
    "narrow": {"numbers.scene_bits": 18, "numbers.vector_fraction": 16, "numbers.direction_fraction": 12,
               "numbers.vertex_bits": 12, "numbers.mantissa_bits": 18, "numbers.fraction_bits": 12,
               "icu.angle_bits": 20, "icu.cordic_stages": 12, "icu.uv_bits": 5, "icu.uv_guard": 4},
}
# Registers of each multiplier.
DEPTHS = (1, 2, 3)


def config_of(changes: dict, preset: str = "tiny") -> Config:
    """A preset with other values of some parameters."""
    return PRESETS[preset].replace(changes)
