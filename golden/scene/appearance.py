"""Materials from the colours of files."""

import numpy as np

from golden.scene.material import Material

__all__ = ["UNSPECIFIED", "bounded_material", "colour_materials", "from_srgb", "to_srgb"]

UNSPECIFIED = Material(name="unspecified", diffuse=(0.5, 0.5, 0.5))
"""Material of a face without one."""


def from_srgb(encoded) -> np.ndarray:
    """Linear values of sRGB values in [0, 1] (IEC 61966-2-1)."""
    encoded = np.asarray(encoded, dtype=np.float64)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def to_srgb(linear) -> np.ndarray:
    """Linear values encoded as sRGB; values outside [0, 1] are clipped."""
    linear = np.clip(np.asarray(linear, dtype=np.float64), 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def bounded_material(name: str, *, diffuse=(0, 0, 0), specular=(0, 0, 0), transparent=(0, 0, 0),
                     refraction_index: float = UNSPECIFIED.refraction_index, thin: bool = False,
                     emission=(0, 0, 0)) -> Material:
    """A material whose shares are scaled down together in each channel in which they sum to more than 1.

    Negative values count as 0, a refraction index below 1 as 1.
    """
    shares = np.maximum(np.array([diffuse, specular, transparent], dtype=np.float64), 0)
    shares /= np.maximum(shares.sum(axis=0), 1)
    diffuse, specular, transparent = (tuple(row) for row in shares.tolist())
    return Material(name=name, diffuse=diffuse, specular=specular, transparent=transparent,
                    refraction_index=max(1.0, float(refraction_index)), thin=thin and refraction_index > 1,
                    emission=tuple(np.maximum(np.asarray(emission, dtype=np.float64), 0).tolist()))


def colour_materials(colours: np.ndarray) -> tuple[tuple, np.ndarray]:
    """Diffuse materials of F x 3 linear colours, one per distinct 8-bit sRGB value, and F indices into them."""
    steps = np.rint(255 * to_srgb(colours)).astype(np.int64)
    different, index = np.unique(steps, axis=0, return_inverse=True)
    names = ["#{:02x}{:02x}{:02x}".format(*row) for row in different.tolist()]
    return tuple(bounded_material(name, diffuse=row) for name, row in
                 zip(names, from_srgb(different / 255), strict=True)), index.reshape(-1)
