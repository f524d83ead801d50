"""Reader of MTL, the material library of OBJ files."""

import math

import numpy as np
from PIL import Image

from golden.errors import InputError
from golden.scene.appearance import UNSPECIFIED, bounded_material, from_srgb
from golden.scene.material import Material

__all__ = ["mean_colour", "read_mtl"]

MIRROR_SHININESS = 500.0
"""Ns (0 to 1000) from which on a highlight counts as a mirror image, whatever ``illum`` says."""

COUNTS = {"Kd": 3, "Ks": 3, "Ke": 3, "Tf": 3, "Ns": 1, "Ni": 1, "d": 1, "Tr": 1, "illum": 1}


def mean_colour(image: Image.Image) -> np.ndarray:
    """Linear mean of an sRGB image, three channels."""
    pixels = np.asarray(image.convert("RGB"), dtype=np.float64) / 255
    return from_srgb(pixels).reshape(-1, 3).mean(axis=0)


def _values(words: list[str], count: int, where: str) -> np.ndarray:
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


def _material(name: str, said: dict) -> Material:
    illum = int(said["illum"][0]) if "illum" in said else 2
    opacity = 1.0
    if "d" in said or "Tr" in said:
        opacity = float(np.clip(said["d"][0] if "d" in said else 1 - said["Tr"][0], 0, 1))
    shines = illum >= 3 or ("Ns" in said and said["Ns"][0] >= MIRROR_SHININESS)
    index = UNSPECIFIED.refraction_index
    if "Ni" in said:
        index = said["Ni"][0]
    if opacity < 1 and (illum < 4 or "Ni" not in said):
        index = 1.0
    return bounded_material(name, diffuse=opacity * said.get("Kd", np.array(UNSPECIFIED.diffuse)),
                            specular=said.get("Ks", np.zeros(3)) if shines else np.zeros(3),
                            transparent=(1 - opacity) * said.get("Tf", np.ones(3)),
                            refraction_index=index, emission=said.get("Ke", np.zeros(3)))


def read_mtl(text: str, *, where: str, folder=None) -> dict[str, Material]:
    """The materials of an MTL file by name.

    Diffuse is ``d`` times ``Kd`` (linear values; a picture in ``map_Kd`` counts with its mean colour), specular is
    ``Ks`` if ``illum`` is 3 or more or ``Ns`` at least 500 (below, Ks is a blurred highlight and left out), transparent
    is ``1 - d`` (or ``Tr``) times ``Tf``. Transparent materials refract by ``Ni`` with ``illum`` 4 and up; else they
    are thin sheets. ``Ke`` is emitted radiance. What adds up to more than 1 is scaled down.

    Parameters
    ----------
    where
        The file's path, for messages.
    folder
        Directory of the pictures; without it they are ignored.

    Errors
    ------
    InputError
        A value is not a finite number, or a picture cannot be read.
    """
    found: dict[str, dict] = {}
    said = None
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        here = f"{where}:{number}"
        key, rest = words[0], words[1:]
        if key == "newmtl":
            said = found.setdefault(" ".join(rest), {})
        elif said is None:
            continue
        elif key in COUNTS and rest and rest[0] not in ("spectral", "xyz"):
            said[key] = _values(rest, COUNTS[key], here)
        elif key == "map_Kd" and folder is not None and rest:
            said["map_Kd"] = _picture(folder, line.split(None, 1)[1].strip(), here)
    for said in found.values():
        if "map_Kd" in said:
            kd = said.get("Kd", np.ones(3))
            said["Kd"] = said["map_Kd"] * (kd if kd.any() else 1)
    return {name: _material(name, said) for name, said in found.items()}


def _picture(folder, name: str, where: str) -> np.ndarray:
    # Options such as "-s 1 1 1" come before the name, which may hold blanks itself.
    path = folder / name.replace("\\", "/")
    if name.startswith("-") and not path.exists():
        path = folder / name.split()[-1]
    try:
        with Image.open(path) as image:
            return mean_colour(image)
    except (OSError, ValueError) as error:
        raise InputError(f"{where}: picture {name!r} cannot be read") from error
