"""Materials: reflectances and emission of surfaces."""

from dataclasses import dataclass, fields

import numpy as np

from golden.base.errors import InputError

__all__ = ["BRIGHTEST", "Material", "Rgb"]

BRIGHTEST = 1e30
"""Largest radiance, intensity or irradiance: sums and squares of lights stay within float64, images within float32."""

Rgb = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Material:
    """Reflectances and emission of a surface, three linear colour channels each.

    Per channel ``diffuse + specular + transparent`` is at most 1: a surface reflects and transmits at most the
    incident light.

    Parameters
    ----------
    name
        Name in messages and exported files.
    diffuse
        Share of the incident light that leaves diffusely (rho).
    specular
        Share that leaves along the mirror direction.
    transparent
        Share that is transmitted, refracted by ``refraction_index``.
    refraction_index
        Index of the inside relative to the outside, at least 1; 1 neither refracts nor mirrors.
    thin
        Whether a transparent face is a sheet with two surfaces of the index: it mirrors at both and bends no ray.
    emission
        Radiance that the front side (both sides where the patch is two-sided) emits, in W/(m2 sr).

    Raises
    ------
    InputError
        A value is not finite, is negative, or a channel's shares sum to more than 1.
    """

    name: str
    diffuse: Rgb = (0.0, 0.0, 0.0)
    specular: Rgb = (0.0, 0.0, 0.0)
    transparent: Rgb = (0.0, 0.0, 0.0)
    refraction_index: float = 1.5
    thin: bool = False
    emission: Rgb = (0.0, 0.0, 0.0)

    def __post_init__(self):
        for field in fields(self):
            if field.type is not Rgb:
                continue
            value = getattr(self, field.name)
            if len(value) != 3 or not np.all(np.isfinite(value)) or min(value) < 0:
                raise InputError(f"material {self.name!r}: {field.name.capitalize()} must be "
                                 f"three finite values of at least 0, not {tuple(value)!r}")
            if max(value) > BRIGHTEST:
                raise InputError(f"material {self.name!r}: {field.name.capitalize()} must be at most {BRIGHTEST:g}, "
                                 f"not {tuple(value)!r}")
            object.__setattr__(self, field.name, tuple(float(channel) for channel in value))
        shares = np.add(np.add(self.diffuse, self.specular), self.transparent)
        if shares.max() > 1 + 1e-9:
            raise InputError(f"material {self.name!r}: Diffuse + specular + transparent must be "
                             f"at most 1 in each channel, not {tuple(shares.tolist())!r}")
        if not np.isfinite(self.refraction_index) or self.refraction_index < 1:
            raise InputError(f"material {self.name!r}: Refraction index must be a finite value of at least 1, "
                             f"not {self.refraction_index!r}")

    @property
    def emits(self) -> bool:
        """Whether the surface is a light."""
        return max(self.emission) > 0
