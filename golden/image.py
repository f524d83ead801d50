"""Picture files, and heat maps of numbers."""

from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image, ImageDraw, ImageFont

from golden.errors import InputError
from golden.output import whole_file

__all__ = ["false_colour", "label_colours", "read_exr", "write_exr", "write_png"]

# Dark to bright with steadily rising luminance, so that the order survives grey printing and colour blindness.
_RAMP = np.array([(0, 0, 8), (72, 12, 104), (176, 42, 96), (240, 104, 40), (252, 190, 52), (255, 252, 208)]) / 255
_LEGEND_HEIGHT = 44
_LEGEND_WIDTH = 256


def write_png(path: Path, image: np.ndarray) -> None:
    """Write H x W x 3 uint8 as PNG, atomically; the same picture gives the same bytes."""
    with whole_file(path) as part:
        Image.fromarray(image).save(part, format="PNG")


def write_exr(path: Path, image: np.ndarray) -> None:
    """Write H x W x 3 linear radiance as OpenEXR (float32, ZIP), atomically; the same picture gives the same bytes."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with whole_file(path) as part:
        try:
            OpenEXR.File(header, {"RGB": np.ascontiguousarray(image, dtype=np.float32)}).write(str(part))
        except RuntimeError as error:
            # The binding raises the system's errors as RuntimeError.
            raise InputError(f"output {str(path)!r}: cannot be written ({error})") from error


def read_exr(path: Path) -> np.ndarray:
    """H x W x 3 float32 of an OpenEXR file with the channels R, G, B."""
    return OpenEXR.File(str(path)).channels()["RGB"].pixels


def false_colour(values: np.ndarray, title: str, *, top: float | None = None) -> np.ndarray:
    """H x W values of at least 0 as a uint8 heat map, black at 0, with a legend below it.

    The legend names ``title``, the mean, and the values at the ends and in the middle of the ramp. Values above ``top``
    have the colour of ``top``, which the legend marks; by default it is the largest value.
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
        above = ">= " if share == 1 and largest > top else ""
        draw.text((4 + share * (legend.width - 8), 29), f"{above}{share * top:.4g}", font=font, fill="white",
                  anchor=anchor)
    canvas = np.zeros((values.shape[0] + _LEGEND_HEIGHT, legend.width, 3), dtype=np.uint8)
    canvas[:values.shape[0], :values.shape[1]] = _ramp(np.minimum(values / top, 1) if top > 0 else values)
    canvas[values.shape[0]:] = np.asarray(legend)
    return canvas


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
