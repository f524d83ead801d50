"""Reader of MTL, the material library of OBJ files."""

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image

from golden.errors import InputError
from golden.scene.appearance import UNSPECIFIED, bounded_material
from golden.scene.material import Material
from golden.scene.parser import check_regular
from golden.scene.texture import MOST_PIXELS, Texture
from golden.scene.unused import Unused

__all__ = ["MtlMaterial", "read_mtl"]

MIRROR_SHININESS = 500.0
"""Least Ns (0 to 1000) at which a highlight counts as a mirror reflection, for any ``illum``."""

SKIPPED = ("Ka", "sharpness")
"""Values without a physical meaning."""

COUNTS = {"Kd": 3, "Ks": 3, "Ke": 3, "Tf": 3, "Ns": 1, "Ni": 1, "d": 1, "Tr": 1, "illum": 1}


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


@dataclass(frozen=True, eq=False)
class MtlMaterial:
    """A material of a library.

    Parameters
    ----------
    name
        Its name.
    stated
        The values that the library states, by keyword.
    texture, picture
        The picture of ``map_Kd`` and its path, or None.
    """

    name: str
    stated: dict
    texture: Texture | None = None
    picture: Path | None = None

    @property
    def _opacity(self) -> float:
        stated = self.stated
        if "d" not in stated and "Tr" not in stated:
            return 1.0
        return float(np.clip(stated["d"][0] if "d" in stated else 1 - stated["Tr"][0], 0, 1))

    @property
    def _shines(self) -> bool:
        return self._illum >= 3 or ("Ns" in self.stated and self.stated["Ns"][0] >= MIRROR_SHININESS)

    @property
    def _illum(self) -> int:
        return int(self.stated["illum"][0]) if "illum" in self.stated else 2

    def add_unused(self, unused: Unused) -> None:
        """Counts the values that have no effect."""
        stated = self.stated
        for key, values in stated.items():
            unused.add(f"negative {key!r}", bool((values < 0).any()))
        for key in "d", "Tr":
            unused.add(f"{key!r} above 1", key in stated and stated[key][0] > 1)
        unused.add("'Ks' of a highlight", not self._shines and bool(stated.get("Ks", np.zeros(3)).any()))
        unused.add("'Tf' of an opaque material",
                   self._opacity == 1 and not (stated.get("Tf", np.ones(3)) == 1).all())

    def material(self, colour=None, *, name: str | None = None) -> Material:
        """The material where the picture has a linear colour; by default where there is no picture."""
        stated, opacity = self.stated, self._opacity
        diffuse = stated.get("Kd", np.array(UNSPECIFIED.diffuse))
        if colour is not None:
            kd = stated.get("Kd", np.ones(3))
            diffuse = colour * (kd if kd.any() else 1)
        index = stated["Ni"][0] if "Ni" in stated else UNSPECIFIED.refraction_index
        if opacity < 1 and (self._illum < 4 or "Ni" not in stated):
            index = 1.0
        return bounded_material(name or self.name, diffuse=opacity * diffuse,
                                specular=stated.get("Ks", np.zeros(3)) if self._shines else np.zeros(3),
                                transparent=(1 - opacity) * stated.get("Tf", np.ones(3)),
                                refraction_index=index, emission=stated.get("Ke", np.zeros(3)))


def read_mtl(text: str, *, where: str, folder=None) -> dict[str, MtlMaterial]:
    """The materials of an MTL file by name.

    Diffuse is ``d`` times ``Kd`` (linear values) times the colour of the picture in ``map_Kd``. Specular is
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
    textures: dict[str, tuple[Texture, Path]] = {}
    stated = name = None
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        here = f"{where}:{number}"
        key, rest = words[0], words[1:]
        if key == "newmtl":
            name = " ".join(rest)
            stated = found.setdefault(name, {})
        elif stated is None:
            continue
        elif key in COUNTS and rest and rest[0] not in ("spectral", "xyz"):
            stated[key] = _values(rest, COUNTS[key], here)
            unused.add(f"'-halo' of {key!r}", "-halo" in rest)
        elif key == "map_Kd" and folder is not None and rest:
            textures[name] = _picture(folder, line.split(None, 1)[1].strip(), here, unused)
        elif key not in SKIPPED:
            unused.add(f"{key!r}")
    materials = {name: MtlMaterial(name, stated, *textures.get(name, ())) for name, stated in found.items()}
    for material in materials.values():
        material.add_unused(unused)
    unused.warn(where)
    return materials


def _picture(folder, name: str, where: str, unused: Unused) -> tuple[Texture, Path]:
    """The picture that a ``map_Kd`` names and its path; InputError if it cannot be read. Counts further options."""
    # Options such as "-s 1 1 1" precede the name, which may itself hold blanks.
    path = folder / name.replace("\\", "/")
    kind = "repeat"
    if name.startswith("-") and not path.exists():
        words = name.split()
        path = folder / words[-1]
        kind = "clamp" if ("-clamp", "on") in pairwise(words) else "repeat"
        for option in words[:-1]:
            unused.add(f"{option!r} of 'map_Kd'", option[0] == "-" and option[1:].isalpha() and option != "-clamp")
    try:
        check_regular(path)
        with Image.open(path) as image:
            return Texture(image, wrap=(kind, kind)), path
    except Image.DecompressionBombError as error:
        raise InputError(f"{where}: picture {name!r} has more than {MOST_PIXELS} pixels") from error
    except (OSError, ValueError, InputError) as error:
        raise InputError(f"{where}: picture {name!r} cannot be read ({' '.join(str(error).split())})") from error
