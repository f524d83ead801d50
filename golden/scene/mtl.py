"""Reader of MTL, the material library of OBJ files."""

import math

import numpy as np
from PIL import Image

from golden.errors import InputError
from golden.scene.appearance import UNSPECIFIED, bounded_material, from_srgb
from golden.scene.material import Material
from golden.scene.parser import check_regular
from golden.scene.unused import Unused

__all__ = ["mean_colour", "read_mtl"]

MIRROR_SHININESS = 500.0
"""Least Ns (0 to 1000) at which a highlight counts as a mirror reflection, for any ``illum``."""

SKIPPED = ("Ka", "sharpness")
"""Values without a physical meaning."""

COUNTS = {"Kd": 3, "Ks": 3, "Ke": 3, "Tf": 3, "Ns": 1, "Ni": 1, "d": 1, "Tr": 1, "illum": 1}


def mean_colour(image: Image.Image) -> np.ndarray:
    """Linear mean of an sRGB picture, three channels.

    Raises
    ------
    InputError
        The picture cannot be decoded.
    """
    try:
        rgb = image.convert("RGB")
    except MemoryError:
        raise
    except Exception as error:  # PIL's decoders raise errors of any type for bad content
        raise InputError(f"a picture cannot be decoded ({error})") from error
    pixels = np.asarray(rgb, dtype=np.float64) / 255
    return from_srgb(pixels).reshape(-1, 3).mean(axis=0)


def _values(words: list[str], count: int, where: str) -> np.ndarray:
    """``count`` finite numbers; a single one stands for all. InputError if they are not."""
    words = [word for word in words if word != "-halo"]
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = []
    if len(values) == 1:
        values = values * count
    if len(values) < count or not all(map(math.isfinite, values)):
        raise InputError(f"{where}: {' '.join(words)!r} is not {'three finite numbers' if count == 3 else 'a number'}")
    return np.array(values[:count])


def _material(name: str, stated: dict, unused: Unused) -> Material:
    """The material of the values that a library states."""
    illum = int(stated["illum"][0]) if "illum" in stated else 2
    opacity = 1.0
    if "d" in stated or "Tr" in stated:
        opacity = float(np.clip(stated["d"][0] if "d" in stated else 1 - stated["Tr"][0], 0, 1))
    shines = illum >= 3 or ("Ns" in stated and stated["Ns"][0] >= MIRROR_SHININESS)
    unused.add("'Ks' of a highlight", not shines and bool(stated.get("Ks", np.zeros(3)).any()))
    unused.add("'Tf' of an opaque material", opacity == 1 and not (stated.get("Tf", np.ones(3)) == 1).all())
    index = UNSPECIFIED.refraction_index
    if "Ni" in stated:
        index = stated["Ni"][0]
    if opacity < 1 and (illum < 4 or "Ni" not in stated):
        index = 1.0
    return bounded_material(name, diffuse=opacity * stated.get("Kd", np.array(UNSPECIFIED.diffuse)),
                            specular=stated.get("Ks", np.zeros(3)) if shines else np.zeros(3),
                            transparent=(1 - opacity) * stated.get("Tf", np.ones(3)),
                            refraction_index=index, emission=stated.get("Ke", np.zeros(3)))


def read_mtl(text: str, *, where: str, folder=None) -> dict[str, Material]:
    """The materials of an MTL file by name.

    Diffuse is ``d`` times ``Kd`` (linear values; a picture in ``map_Kd`` counts with its mean colour). Specular is
    ``Ks`` if ``illum`` is 3 or more or ``Ns`` at least 500; below that Ks is a glossy highlight and omitted.
    Transparent is ``1 - d`` (or ``Tr``) times ``Tf``. Transparent materials refract by ``Ni`` with ``illum`` 4 and
    more; otherwise they are thin sheets. ``Ke`` is emitted radiance. Shares that sum to more than 1 are scaled down.

    Parameters
    ----------
    text
        Content of the file.
    where
        Path of the file, for messages.
    folder
        Directory of the pictures; without it they are not used.

    Raises
    ------
    InputError
        A value is not a finite number, or a picture cannot be read.

    Warns
    -----
    InputWarning
        Names what is not used.
    """
    unused = Unused()
    found: dict[str, dict] = {}
    stated = None
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        here = f"{where}:{number}"
        key, rest = words[0], words[1:]
        if key == "newmtl":
            stated = found.setdefault(" ".join(rest), {})
        elif stated is None:
            continue
        elif key in COUNTS and rest and rest[0] not in ("spectral", "xyz"):
            stated[key] = _values(rest, COUNTS[key], here)
        elif key == "map_Kd" and folder is not None and rest:
            stated["map_Kd"] = _picture(folder, line.split(None, 1)[1].strip(), here)
        elif key not in SKIPPED:
            unused.add(f"{key!r}")
    for stated in found.values():
        if "map_Kd" in stated:
            kd = stated.get("Kd", np.ones(3))
            stated["Kd"] = stated["map_Kd"] * (kd if kd.any() else 1)
    materials = {name: _material(name, stated, unused) for name, stated in found.items()}
    unused.warn(where)
    return materials


def _picture(folder, name: str, where: str) -> np.ndarray:
    """Linear mean of the picture that a ``map_Kd`` names; InputError if it cannot be read."""
    # Options such as "-s 1 1 1" precede the name, which may itself hold blanks.
    path = folder / name.replace("\\", "/")
    if name.startswith("-") and not path.exists():
        path = folder / name.split()[-1]
    try:
        check_regular(path)
        with Image.open(path) as image:
            return mean_colour(image)
    except (OSError, ValueError, Image.DecompressionBombError, InputError) as error:
        raise InputError(f"{where}: picture {name!r} cannot be read") from error
