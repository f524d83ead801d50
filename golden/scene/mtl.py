"""Reader of MTL, the material library of OBJ files."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from golden.base.errors import InputError
from golden.base.input_warnings import warn
from golden.scene.appearance import UNSPECIFIED, bounded_material
from golden.scene.file_text import file_of, forms_of, is_number, lines_of, numbers, unquoted
from golden.scene.material import Material
from golden.scene.parser import check_regular
from golden.scene.texture import MOST_PIXELS, Texture
from golden.scene.unused import Unused

__all__ = ["MtlMaterial", "read_mtl"]

MIRROR_SHININESS = 500.0
"""Least Ns (0 to 1000) at which a highlight counts as a mirror reflection, for any ``illum``."""

LARGEST_SHININESS = 1000.0
"""Ns of the sharpest highlight."""

SKIPPED = ("Ka", "sharpness")
"""Values without a physical meaning."""

OPTIONS = {"-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-colorspace": 1, "-imfchan": 1,
           "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-type": 1}
"""Options of pictures, and the most words that each takes; three are one number at least."""

COUNTS = {"Kd": 3, "Ks": 3, "Ke": 3, "Tf": 3, "Ns": 1, "Ni": 1, "d": 1, "Tr": 1, "illum": 1}


def _values(words: list[str], count: int, where: str) -> np.ndarray:
    """``count`` finite numbers; a single one stands for all. InputError if they are not."""
    words = [word for word in words if word != "-halo"]
    try:
        values = numbers(words)
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
    scale, offset
        What multiplies the texture coordinates, and what is added to them then.
    """

    name: str
    stated: dict
    texture: Texture | None = None
    picture: Path | None = None
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)

    def placed(self, uv: np.ndarray) -> np.ndarray:
        """K x 2 coordinates in the picture at texture coordinates of the file."""
        return uv * self.scale + self.offset

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
        unused.add("'Tr' that contradicts 'd'",
                   {"d", "Tr"} <= stated.keys() and abs(stated["d"][0] + stated["Tr"][0] - 1) > 1e-6)
        unused.add("'Ni' below 1", "Ni" in stated and stated["Ni"][0] < 1)
        unused.add("'Kd' of 0 with a picture", self.texture is not None and not stated.get("Kd", np.ones(3)).any())
        shares = (self._opacity * stated.get("Kd", np.array(UNSPECIFIED.diffuse))
                  + (1 - self._opacity) * stated.get("Tf", np.ones(3))
                  + (stated.get("Ks", np.zeros(3)) if self._shines else 0))
        unused.add("shares beyond a sum of 1", shares.max() > 1 + 1e-9)
        unused.add("spread of a highlight", self._shines and self._illum < 3 and stated.get("Ks", np.zeros(3)).any()
                   and stated["Ns"][0] < LARGEST_SHININESS)
        unused.add("'Ni' without refraction", self._opacity < 1 and self._illum < 4 and stated.get("Ni", [1])[0] > 1)
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


def read_mtl(data: bytes, *, where: str, folder=None) -> dict[str, MtlMaterial]:
    """The materials of an MTL file by name.

    Diffuse is ``d`` times ``Kd`` (linear values) times the colour of the picture in ``map_Kd``. Specular is
    ``Ks`` if ``illum`` is 3 or more or ``Ns`` at least 500; below that Ks is a glossy highlight and omitted.
    Transparent is ``1 - d`` (or ``Tr``) times ``Tf``. Transparent materials refract by ``Ni`` with ``illum`` 4 and
    more; otherwise they are thin sheets. ``Ke`` is emitted radiance. Shares that sum to more than 1 are scaled down.

    Parameters
    ----------
    data
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
        Names what is not used, materials that are defined twice, and pictures that do not exist.
    """
    unused = Unused()
    found: dict[str, dict] = {}
    pictures: dict[str, dict] = {}
    stated = name = None
    for number, line in enumerate(lines_of(data), start=1):
        key, *rest = line.split(None, 1)[:2] or "#"
        if key.startswith("#"):
            continue
        here, text = f"{where}:{number}", rest[0].strip() if rest else ""
        words = re.split(r"(?:^|\s)#", text, maxsplit=1)[0].split()
        if key == "newmtl":
            name = text
            if name in found:
                warn(f"{here}: material {name!r} is defined again: the first definition is not used")
                pictures.pop(name, None)
            stated = found[name] = {}
        elif stated is None:
            unused.add(f"{key!r} before any material")
        elif key in COUNTS and words and words[0] not in ("spectral", "xyz"):
            unused.add(f"earlier {key!r} of a material", key in stated)
            stated[key] = _values(words, COUNTS[key], here)
            unused.add(f"'-halo' of {key!r}", "-halo" in words)
            unused.add(f"further values of {key!r}", len(words) - ("-halo" in words) > COUNTS[key])
        elif key == "map_Kd" and folder is not None and text:
            unused.add("earlier 'map_Kd' of a material", name in pictures)
            pictures[name] = _picture(folder, text, here, unused)
        elif key not in SKIPPED:
            unused.add(f"{key!r}")
    materials = {name: MtlMaterial(name, stated, **pictures.get(name, {})) for name, stated in found.items()}
    for material in materials.values():
        material.add_unused(unused)
    unused.warn(where)
    return materials


def _options(text: str) -> tuple[dict[str, list[str]], str]:
    """The options at the start of a text, with their words, and the rest."""
    options = {}
    while (head := text.split(None, 1)) and head[0] in OPTIONS:
        option, text, values = head[0], head[1] if len(head) > 1 else "", []
        for rank in range(OPTIONS[option]):
            word, *more = text.split(None, 1) or [""]
            if not word or (rank and OPTIONS[option] == 3 and not is_number(word)):
                break
            values.append(word)
            text = more[0] if more else ""
        options[option] = values
    return options, text.strip()


def _named(folder, text):
    """The path of a picture and its options, which may precede its name or follow it; the name may hold blanks."""
    given = {}
    for part in forms_of(text):
        options, rest = _options(part)
        last = re.search(rf"\s({'|'.join(OPTIONS)})(?=\s|$)", rest)
        name, more = (rest[:last.start()].rstrip(), _options(rest[last.start():])[0]) if last else (rest, {})
        for candidate, its in ((part, {}), (rest, options), (name, options | more)):
            for one in (candidate, unquoted(candidate)):
                given.setdefault(one, its)
    path, name = file_of(folder, list(given)) or (folder / unquoted(name).replace("\\", "/"), unquoted(name))
    return path, given[name]


def _picture(folder, text: str, where: str, unused: Unused) -> dict:
    """The members of a material with the picture of a ``map_Kd``, none if there is no such file; counts its options.

    Raises
    ------
    InputError
        The picture cannot be read.
    """
    path, options = _named(folder, text)
    if path == folder:
        unused.add("'map_Kd' without a name")
        return {}
    for option in options.keys() - {"-clamp", "-s", "-o"}:
        unused.add(f"{option!r} of 'map_Kd'")
    scale, offset = (_pair(options.get(name, []), default, where) for name, default in (("-s", 1.0), ("-o", 0.0)))
    kind = "clamp" if options.get("-clamp") == ["on"] else "repeat"
    try:
        check_regular(path)
        with Image.open(path) as image:
            texture = Texture(image, wrap=(kind, kind))
    except FileNotFoundError:
        warn(f"{where}: there is no picture {path.name!r}: 'Kd' alone is used")
        return {}
    except Image.DecompressionBombError as error:
        raise InputError(f"{where}: picture {path.name!r} has more than {MOST_PIXELS} pixels") from error
    except (OSError, ValueError, InputError) as error:
        raise InputError(f"{where}: picture {path.name!r} cannot be read ({' '.join(str(error).split())})") from error
    unused.add("alpha of 'map_Kd'", texture.has_alpha)
    unused.add("further frames of 'map_Kd'", texture.has_frames)
    return {"texture": texture, "picture": path, "scale": scale, "offset": offset}


def _pair(words, default, where):
    """Two numbers of the words, by default ``default``; a third one does not count."""
    return tuple(float(_values([word], 1, where)[0]) for word in [*words, str(default), str(default)][:2])
