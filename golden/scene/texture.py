"""Pictures on faces: colours at points, and means over faces."""

import numpy as np
from PIL import Image

from golden.base.errors import InputError
from golden.scene.appearance import from_srgb

__all__ = ["MOST_PIXELS", "Texture", "join_halves"]

MOST_PIXELS = 1 << 26
"""Most pixels of a picture that is read: 192 MiB decoded."""

FINEST = 128
"""Most parts along each side of a triangle in which a picture is sampled."""

BLOCK = 1 << 16
"""Samples at a time, which stay in a processor's cache."""

PARALLEL = 1e-6
"""Largest sine between the normals of two triangles that count as coplanar."""

_LINEAR = from_srgb(np.arange(256) / 255)


def _repeat(position, count):
    return position % count


def _clamp(position, count):
    return np.clip(position, 0, count - 1)


def _mirror(position, count):
    position = position % (2 * count)
    return np.minimum(position, 2 * count - 1 - position)


_WRAPS = {"repeat": _repeat, "clamp": _clamp, "mirror": _mirror}


class Texture:
    """A decoded sRGB picture.

    Parameters
    ----------
    image
        The picture; it is decoded here.
    wrap
        What is outside the picture along its width and its height: ``"repeat"``, ``"clamp"`` or ``"mirror"``.

    Members
    -------
    has_alpha
        Whether the picture states an opacity below 1, which is not used.
    has_frames
        Whether the file has further pictures, which are not used.

    Raises
    ------
    InputError
        The picture has more than `MOST_PIXELS`, cannot be decoded or has values of a kind that sRGB has not.
    """

    def __init__(self, image: Image.Image, *, wrap: tuple[str, str] = ("repeat", "repeat")):
        width, height = image.size
        if width * height > MOST_PIXELS:
            raise InputError(f"a picture has {width} x {height} pixels, at most {MOST_PIXELS} are read")
        try:
            self.has_alpha = image.has_transparency_data and image.convert("RGBA").getextrema()[3][0] < 255
            self._pixels = _rgb(image)
            self.has_frames = getattr(image, "is_animated", False)
        except (InputError, MemoryError):
            raise
        except Exception as error:  # PIL's decoders raise errors of any type for bad content
            raise InputError(f"a picture cannot be decoded ({error})") from error
        self._wrap = [_WRAPS[kind] for kind in wrap]

    @property
    def pixels(self) -> int:
        """Number of its pixels."""
        return self._pixels.shape[0] * self._pixels.shape[1]

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Linear colours at K x 2 texture coordinates, K x 3: bilinear between the centres of four texels."""
        height, width, _ = self._pixels.shape
        column, row = uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5
        left, above = np.floor(column), np.floor(row)
        right_share, below_share = column - left, row - above
        result = np.zeros((len(uv), 3))
        for down in (0, 1):
            for across in (0, 1):
                weight = np.abs(1 - across - right_share) * np.abs(1 - down - below_share)
                x, y = (self._wrap[axis](first.astype(np.int64) + step, count) for axis, first, step, count in (
                    (0, left, across, width), (1, above, down, height)))
                result += weight[:, None] * _LINEAR[self._pixels[y, x]]
        return result

    def mean(self) -> np.ndarray:
        """Linear mean of the whole picture, three channels."""
        height, width, _ = self._pixels.shape
        counts = np.zeros((3, 256))
        step = max(1, BLOCK // width)
        for first in range(0, height, step):
            counts += [np.bincount(part.ravel(), minlength=256) for part in
                       np.moveaxis(self._pixels[first:first + step], 2, 0)]
        return counts @ _LINEAR / (height * width)

    def means(self, uv: np.ndarray) -> np.ndarray:
        """Linear mean over the texels of each triangle, F x 3.

        Triangles of more than `FINEST` / 2 texels have an estimate without bias, of a standard error of at most 0.004.

        Parameters
        ----------
        uv
            F x 3 x 2 texture coordinates of the corners, (0, 0) at the picture's lower left corner.

        Raises
        ------
        InputError
            A coordinate is not finite, or beyond 1e9.
        """
        if not (np.abs(uv) <= 1e9).all():
            raise InputError("a texture coordinate is not finite or beyond 1e9")
        height, width, _ = self._pixels.shape
        texels = np.stack([uv[..., 0] * width, (1 - uv[..., 1]) * height], axis=2)
        longest = np.linalg.norm(texels - np.roll(texels, 1, axis=1), axis=2).max(axis=1)
        # Two parts along a texel leave the texels at the rim as the only ones that are inexact.
        parts = np.clip(np.ceil(2 * longest), 2, FINEST).astype(int)
        pixels, result = self._pixels.reshape(-1, 3), np.empty((len(uv), 3))
        for count in np.unique(parts).tolist():
            weights = _samples(count)
            chosen = np.flatnonzero(parts == count)
            step = max(1, BLOCK // len(weights))
            for first in range(0, len(chosen), step):
                rows = chosen[first:first + step]
                column, row = (self._wrap[axis](np.floor(weights @ texels[rows, :, axis].T).astype(np.int64), size)
                               for axis, size in enumerate((width, height)))
                seen = pixels.take(row * width + column, axis=0)
                result[rows] = _LINEAR.take(seen).mean(axis=0)
        return result


def _rgb(image):
    """The pixels in 8 bits. Pillow would clip 16 bits to white."""
    if image.mode == "F":
        raise InputError("a picture of floating-point values is not read")
    if not image.mode.startswith("I"):
        return np.asarray(image.convert("RGB"))
    grey = np.asarray(image).astype(np.int64)
    if grey.min() < 0 or grey.max() > 65535:
        raise InputError("a picture has values beyond 16 bits")
    return np.repeat(np.rint(grey / 257).astype(np.uint8)[..., None], 3, axis=2)


def _samples(count):
    """Barycentric coordinates of a point in each of ``count`` squared congruent parts of a triangle.

    These are the parts' centres, or, of `FINEST` parts along a side, which may be longer than a texel, random points:
    in pictures that repeat, evenly spaced ones may meet the same texels again and again.
    """
    i, j = (grid.ravel() for grid in np.meshgrid(np.arange(count), np.arange(count)))
    upright, turned = i + j < count, i + j < count - 1
    i, j = (np.concatenate([side[upright], side[turned]]) for side in (i, j))
    turned = np.arange(len(i)) >= upright.sum()
    place = np.where(turned, 2 / 3, 1 / 3) * np.ones((2, 1))
    if count == FINEST:
        place = np.random.default_rng(0).random(place.shape)
        place = np.where((place.sum(axis=0) < 1) == turned, 1 - place, place)
    first, second = (i + place[0]) / count, (j + place[1]) / count
    return np.stack([1 - first - second, first, second], axis=1)


def join_halves(corners: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """F x C colours in which the two halves of a quadrilateral have their mean, weighted by area.

    Halves are coplanar triangles that follow one another and share two corners: with equal colours they stay one patch.

    Parameters
    ----------
    corners
        F x 3 x 3 triangles.
    colours
        F x C colours.
    """
    if len(corners) < 2:
        return colours
    vectors = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(vectors, axis=1)
    same = (corners[:-1, :, None] == corners[1:, None]).all(axis=3).sum(axis=(1, 2))
    sine = np.linalg.norm(np.cross(vectors[:-1], vectors[1:]), axis=1)
    along = np.einsum("fk,fk->f", vectors[:-1], vectors[1:]) > 0
    joins = (same == 2) & along & (sine <= PARALLEL * areas[:-1] * areas[1:])
    result = colours.copy()
    last = -1
    for first in np.flatnonzero(joins).tolist():
        if first == last:
            continue
        last = first + 1
        total = areas[first] + areas[last]
        result[first:last + 1] = (areas[first] * colours[first] + areas[last] * colours[last]) / total
    return result
