"""Picture files, and heat maps of numbers."""

import struct
import zlib
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image, ImageDraw, ImageFont
from PIL.PngImagePlugin import PngInfo

from golden.base.errors import InputError
from golden.base.output import whole_file

__all__ = ["false_colour", "label_colours", "write_exr", "write_png"]

# Of ITU-R BT.709: x and y of red, green, blue and white.
_BT_709 = 0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329

# Dark to bright with steadily rising luminance, so that the order survives grey printing and colour blindness.
_RAMP = np.array([(0, 0, 8), (72, 12, 104), (176, 42, 96), (240, 104, 40), (252, 190, 52), (255, 252, 208)]) / 255
_LEGEND_HEIGHT = 44
_LEGEND_WIDTH = 256


def write_png(path: Path, image: np.ndarray, *, gamma: float | None = None) -> None:
    """Write H x W x 3 uint8 or uint16 as PNG, atomically; the same picture gives the same bytes.

    The file states the primaries of BT.709, and the display's curve: that of sRGB, or the power law ``gamma``.
    """
    chunks = {b"cHRM": struct.pack(">8I", *(round(100_000 * value) for value in (*_BT_709[6:], *_BT_709[:6]))),
              b"gAMA": struct.pack(">I", round(100_000 / (gamma or 2.2)))}
    if gamma is None:
        chunks[b"sRGB"] = b"\0"
    with whole_file(path) as part:
        if image.dtype == np.uint16:
            part.write_bytes(_deep_png(image, chunks))
        else:
            known = PngInfo()
            for name, data in chunks.items():
                known.add(name, data)
            Image.fromarray(image).save(part, format="PNG", pnginfo=known)


def _deep_png(image, chunks):
    """The bytes of a PNG of 16 bits a channel, which Pillow does not write: each row as differences from that above."""
    rows = image.astype(">u2").reshape(len(image), -1).view(np.uint8)
    rows = np.diff(rows, axis=0, prepend=np.zeros_like(rows[:1]))
    rows = np.concatenate([np.full((len(rows), 1), 2, dtype=np.uint8), rows], axis=1)
    header = struct.pack(">2I5B", image.shape[1], image.shape[0], 16, 2, 0, 0, 0)
    parts = {b"IHDR": header, **chunks, b"IDAT": zlib.compress(rows.tobytes()), b"IEND": b""}
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts.items())


def write_exr(path: Path, image: np.ndarray, *, white: float) -> None:
    """Write H x W x 3 linear radiance as OpenEXR (float32, ZIP), atomically; the same picture gives the same bytes.

    The file states the primaries of BT.709, and ``white``, the luminance of the radiance (1, 1, 1) in cd/m2.
    """
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, "chromaticities": _BT_709,
              "whiteLuminance": float(white)}
    with whole_file(path) as part:
        try:
            OpenEXR.File(header, {"RGB": np.ascontiguousarray(image, dtype=np.float32)}).write(str(part))
        except RuntimeError as error:
            # The binding raises the system's errors as RuntimeError.
            raise InputError(f"output {str(path)!r}: cannot be written ({error})") from error


def false_colour(values: np.ndarray, title: str, *, top: float | None = None,
                 decades: float | None = None) -> np.ndarray:
    """H x W values of at least 0 as a uint8 heat map, black at 0, with a legend below it.

    The legend names ``title``, the mean, and the values at the ends and in the middle of the ramp. Values above ``top``
    have the colour of ``top``, which the legend marks; by default it is the largest value. With ``decades`` the ramp
    is logarithmic over so many powers of ten below ``top``, and all that is less is black.
    """
    largest = float(values.max())
    top = largest if not top else min(top, largest)
    legend = Image.new("RGB", (max(_LEGEND_WIDTH, values.shape[1]), _LEGEND_HEIGHT))
    draw = ImageDraw.Draw(legend)
    font = ImageFont.load_default(size=11)
    draw.text((4, 2), f"{title}, mean {float(values.mean()):.3g}", font=font, fill="white")
    ramp = _ramp(np.broadcast_to(np.linspace(0, 1, legend.width - 8), (10, legend.width - 8)))
    legend.paste(Image.fromarray(ramp), (4, 18))
    for share, anchor in ((0, "la"), (0.5, "ma"), (1, "ra")):
        beyond = ">= " if share == 1 and largest > top else "<= " if share == 0 and decades else ""
        value = share * top if decades is None else top * 10**((share - 1) * decades)
        draw.text((4 + share * (legend.width - 8), 29), f"{beyond}{value:.4g}", font=font, fill="white", anchor=anchor)
    canvas = np.zeros((values.shape[0] + _LEGEND_HEIGHT, legend.width, 3), dtype=np.uint8)
    canvas[:values.shape[0], :values.shape[1]] = _ramp(_shares(values, top, decades))
    canvas[values.shape[0]:] = np.asarray(legend)
    return canvas


def _shares(values, top, decades):
    """Where values are on the ramp, 0 to 1."""
    if not top > 0:
        return values
    shares = np.minimum(values / top, 1)
    return shares if decades is None else np.maximum(
        1 + np.log10(np.maximum(shares, 10.0**-decades)) / decades, 0)


def label_colours(labels: np.ndarray) -> np.ndarray:
    """H x W whole numbers as uint8 colours, the same for the same number, and far apart for neighbouring ones; numbers
    below 0 are black.
    """
    # Steps by the golden ratio keep successive hues far apart; three shades distinguish near hues.
    hue = labels * ((np.sqrt(5) - 1) / 2) % 1
    channel = np.clip(np.abs((hue[..., None] + np.array([0, 2, 1]) / 3) % 1 * 6 - 3) - 1, 0, 1)
    shade = np.array([1.0, 0.75, 0.55])[labels % 3]
    colour = (0.2 + 0.8 * channel) * shade[..., None] * (labels >= 0)[..., None]
    return np.rint(255 * colour).astype(np.uint8)


def _ramp(share: np.ndarray) -> np.ndarray:
    stops = np.linspace(0, 1, len(_RAMP))
    colour = np.stack([np.interp(share, stops, channel) for channel in _RAMP.T], axis=-1)
    return np.rint(255 * colour).astype(np.uint8)
