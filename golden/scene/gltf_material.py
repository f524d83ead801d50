"""Materials of glTF."""

import numpy as np

from golden.scene.appearance import UNSPECIFIED, bounded_material
from golden.scene.material import Material

__all__ = ["EXACT", "EXACT_SHARES", "MIRROR_ROUGHNESS", "gltf_material"]

MIRROR_ROUGHNESS = 0.25
"""Largest roughness of a metal that counts as a mirror; above it the reflection counts as diffuse."""

EXACT = "radiosity_engine"
"""Key in a material's extras of its exact shares, written where glTF's own model cannot express them."""

EXACT_SHARES = ("diffuse", "specular", "transparent", "refraction_index", "thin", "emission")


def gltf_material(source: dict, name: str, *, colour=None, emission_colour=None) -> Material:
    """The material of a glTF material object.

    base = ``baseColorFactor`` times ``colour`` (of texture and vertex colours). Metals reflect base as mirrors
    with ``roughnessFactor`` up to 0.25, else diffusely. Dielectrics reflect base diffusely, less the share that
    ``KHR_materials_transmission`` transmits. With ``alphaMode`` BLEND the share 1 - alpha is transmitted unrefracted.
    ``KHR_materials_ior`` is the index of both; only bodies (``KHR_materials_volume`` with a thickness) refract, all
    else is a thin sheet.
    ``emissiveFactor`` times ``KHR_materials_emissive_strength`` is radiance.
    """
    exact = source.get("extras")
    exact = exact.get(EXACT) if isinstance(exact, dict) else None
    if exact:
        return bounded_material(name, **{share: exact[share] for share in EXACT_SHARES if share in exact})
    pbr, extensions = source.get("pbrMetallicRoughness", {}), source.get("extensions", {})
    *base, alpha = pbr.get("baseColorFactor", (1, 1, 1, 1))
    base = np.clip(np.array(base, dtype=np.float64) * (1 if colour is None else colour), 0, 1)
    metallic = float(np.clip(pbr.get("metallicFactor", 1.0), 0, 1))
    alpha = float(np.clip(alpha, 0, 1)) if source.get("alphaMode") == "BLEND" else 1.0
    transmitted = float(np.clip(extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0), 0, 1))
    mirror = pbr.get("roughnessFactor", 1.0) <= MIRROR_ROUGHNESS
    body = (1 - metallic) * base
    transparent = alpha * transmitted * body + (1 - alpha)
    index = extensions.get("KHR_materials_ior", {}).get("ior", UNSPECIFIED.refraction_index)
    thin = transparent.any() and not extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0.0) > 0
    if thin and not transmitted:  # a share of the face is open
        index = 1.0
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    emission = strength * np.array(source.get("emissiveFactor", (0, 0, 0)), dtype=np.float64)
    return bounded_material(
        name, diffuse=alpha * ((1 - transmitted) * body + (0 if mirror else metallic * base)),
        specular=alpha * metallic * base if mirror else np.zeros(3), transparent=transparent, refraction_index=index,
        thin=bool(thin), emission=emission * (1 if emission_colour is None else emission_colour))
