"""Numbers and pictures of a glTF file, from its buffers."""

import base64
import binascii
from io import BytesIO
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

import numpy as np
from PIL import Image

from golden.base.errors import InputError
from golden.base.input_warnings import warn
from golden.scene.parser import check_regular
from golden.scene.texture import MOST_PIXELS, Texture

__all__ = ["COMPONENTS", "WIDTHS", "GltfBuffers"]

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""Types of numbers by their codes."""

WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
"""Numbers of an entry."""

WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
"""Modes of samplers outside of a picture."""

WEBP = "EXT_texture_webp"


class GltfBuffers:
    """The buffers, accessors and textures of a file whose JSON part was checked.

    Parameters
    ----------
    tree
        The JSON part.
    path
        The file's path, beside which further files are.
    chunk
        The binary part of a GLB file.

    Members
    -------
    files
        The further files that it names.

    Raises
    ------
    InputError
        A further file is outside of the file's folder or not a regular file, or its name is none.
    """

    def __init__(self, tree: dict, path: Path, chunk: bytes):
        self._tree, self._folder, self._chunk = tree, path.parent, chunk
        self._buffers: dict[int, bytes] = {}
        self._textures: dict[tuple, Texture | None] = {}
        self.files = tuple(self._beside(part["uri"]) for name in ("buffers", "images") for part in tree.get(name, ())
                           if "uri" in part and not part["uri"].startswith("data:"))
        for file in self.files:
            try:
                is_beside = file.resolve().is_relative_to(self._folder.resolve())
            except ValueError as error:  # a zero byte, or half of a surrogate pair
                raise InputError(f"{str(file)!r} cannot be read ({error})") from error
            if not is_beside:
                raise InputError(f"{file} is not read: it is outside of the file's folder")
            check_regular(file)

    def _beside(self, uri):
        decoded, plain = self._folder / unquote(uri), self._folder / uri
        return plain if plain.exists() and not decoded.exists() else decoded

    def _bytes(self, uri, what):
        if not uri.startswith("data:"):
            return self._beside(uri).read_bytes()
        head, _, body = uri.partition(",")
        try:
            return base64.b64decode(unquote_to_bytes(body), validate=True) if head.endswith(";base64") \
                else unquote_to_bytes(body)
        except binascii.Error as error:
            raise InputError(f"{what} is no base64 ({error})") from error

    def _buffer(self, number):
        if number not in self._buffers:
            buffer = self._tree["buffers"][number]
            try:
                data = self._bytes(buffer["uri"], f"buffers[{number}].uri") if "uri" in buffer else self._chunk
            except InputError:
                raise
            except (OSError, ValueError) as error:
                reason = getattr(error, "strerror", None) or error
                raise InputError(f"buffer {unquote(buffer['uri'])!r} cannot be read ({reason})") from error
            if len(data) < buffer["byteLength"]:
                raise InputError(f"buffers[{number}] has {len(data)} bytes and should have {buffer['byteLength']}")
            self._buffers[number] = data
        return self._buffers[number]

    def _view(self, number, what):
        view = self._tree["bufferViews"][number]
        start, data = view.get("byteOffset", 0), self._buffer(view["buffer"])
        if start + view["byteLength"] > len(data):
            raise InputError(f"{what} ends behind its buffer")
        return memoryview(data)[start:start + view["byteLength"]], view.get("byteStride")

    def _table(self, number, offset, kind, shape, what):
        """``shape`` numbers of a buffer view."""
        data, stride = self._view(number, what)
        kind = np.dtype(kind)
        stride = stride or shape[1] * kind.itemsize
        if shape[0] and offset + (shape[0] - 1) * stride + shape[1] * kind.itemsize > len(data):
            raise InputError(f"{what} ends behind its buffer view")
        return np.ndarray(shape, kind, data, offset, (stride, kind.itemsize)) if shape[0] else np.empty(shape, kind)

    def values(self, number: int, *types: str) -> np.ndarray:
        """The entries of an accessor of one of these types, K x W; normalised integers become floats.

        Raises
        ------
        InputError
            It has another type, they are not within their buffers, or a buffer cannot be read.
        """
        accessor, what = self._tree["accessors"][number], f"accessors[{number}]"
        if accessor["type"] not in types:
            raise InputError(f"{what}.type must be {' or '.join(types)}, not {accessor['type']!r}")
        kind, count = COMPONENTS[accessor["componentType"]], accessor["count"]
        shape = (count, WIDTHS[accessor["type"]])
        if "bufferView" in accessor:
            table = self._table(accessor["bufferView"], accessor.get("byteOffset", 0), kind, shape, what)
        else:
            table = np.zeros(shape, kind)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            places, values = (self._table(part["bufferView"], part.get("byteOffset", 0), part_kind,
                                          (sparse["count"], width), f"{what}.sparse") for part, part_kind, width in (
                (sparse["indices"], COMPONENTS[sparse["indices"]["componentType"]], 1),
                (sparse["values"], kind, shape[1])))
            if len(places) and places.max() >= count:
                raise InputError(f"{what}.sparse has a value for entry {places.max()} of {count}")
            table = table.copy()
            table[places[:, 0].astype(np.int64)] = values
        if accessor.get("normalized") and table.dtype.kind != "f":
            return np.maximum(table / np.iinfo(table.dtype).max, -1.0)
        return table

    def texture(self, number: int, what: str) -> Texture | None:
        """The picture of a texture, of which ``what`` names the use; None with a warning if there is no such file.

        Raises
        ------
        InputError
            It cannot be read or decoded.
        """
        texture = self._tree["textures"][number]
        source = texture.get("extensions", {}).get(WEBP, {}).get("source", texture.get("source"))
        if source is None:
            warn(f"texture {number} has no picture that can be read: {what} is not used")
            return None
        sampler = self._tree["samplers"][texture["sampler"]] if "sampler" in texture else {}
        wrap = tuple(WRAPS.get(sampler.get(name), "repeat") for name in ("wrapS", "wrapT"))
        if (source, wrap) not in self._textures:
            self._textures[source, wrap] = self._picture(source, wrap, f"{what} {number}")
        return self._textures[source, wrap]

    def _picture(self, number, wrap, what):
        image = self._tree["images"][number]
        try:
            data = (self._bytes(image["uri"], f"images[{number}].uri") if "uri" in image
                    else bytes(self._view(image["bufferView"], f"images[{number}]")[0]))
            with Image.open(BytesIO(data)) as picture:
                return Texture(picture, wrap=wrap)
        except FileNotFoundError:
            warn(f"there is no picture {unquote(image['uri'])!r}: {what} is not used")
            return None
        except InputError:
            raise
        except (OSError, ValueError, Image.DecompressionBombError) as error:
            raise InputError(f"{what} cannot be read as a picture of at most {MOST_PIXELS} pixels") from error
