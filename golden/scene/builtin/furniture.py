"""Pieces of furniture, each standing on z = 0 around the origin before it is placed; none has a face on the ground."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import box, placed
from golden.scene.material import Material
from golden.scene.tessellate import revolution

__all__ = ["armchair", "bookshelf", "chair", "computer", "floor_lamp", "plant", "sheets", "table", "vase"]

OAK = Material(name="oak", diffuse=(0.50, 0.32, 0.16))
WALNUT = Material(name="walnut", diffuse=(0.25, 0.13, 0.07))
CLOTH = Material(name="green cloth", diffuse=(0.12, 0.26, 0.18))
CASE = Material(name="computer case", diffuse=(0.62, 0.60, 0.54))
DISPLAY = Material(name="display", diffuse=(0.04, 0.10, 0.16), specular=(0.08, 0.08, 0.08))
CLAY = Material(name="clay", diffuse=(0.55, 0.27, 0.16))
EARTH = Material(name="earth", diffuse=(0.10, 0.07, 0.05))
LEAF = Material(name="leaf", diffuse=(0.12, 0.36, 0.08))
BRASS = Material(name="brass", diffuse=(0.35, 0.26, 0.10), specular=(0.25, 0.20, 0.08))
SHADE = Material(name="lamp shade", diffuse=(0.78, 0.70, 0.55))
BULB = Material(name="opal glass", diffuse=(0.80, 0.80, 0.78))
PAPER = Material(name="paper", diffuse=(0.85, 0.85, 0.82))
COVERS = tuple(Material(name=f"book {name}", diffuse=diffuse) for name, diffuse in (
    ("red", (0.48, 0.07, 0.06)), ("blue", (0.08, 0.14, 0.42)), ("green", (0.08, 0.28, 0.14)),
    ("ochre", (0.60, 0.40, 0.12)), ("grey", (0.40, 0.40, 0.42)), ("ivory", (0.74, 0.70, 0.58))))


def _legs(width: float, depth: float, height: float, thickness: float) -> np.ndarray:
    """Four legs without ends, 16 patches."""
    leg = box((-thickness / 2,) * 2 + (0.0,), (thickness / 2,) * 2 + (height,), omit=("-z", "+z"))
    x, y = (width - thickness) / 2, (depth - thickness) / 2
    return np.concatenate([placed(leg, at=(i * x, j * y, 0.0)) for i in (-1, 1) for j in (-1, 1)])


def table(builder: SceneBuilder, *, width: float, depth: float, height: float = 0.74, **pose) -> None:
    """A board on four legs, 22 patches."""
    board = box((-width / 2, -depth / 2, height - 0.05), (width / 2, depth / 2, height))
    legs = _legs(width - 0.1, depth - 0.1, height - 0.05, 0.07)
    builder.add(placed(np.concatenate([board, legs]), **pose), OAK)


def chair(builder: SceneBuilder, **pose) -> None:
    """A seat that looks along +y, with a straight back, 27 patches."""
    seat = box((-0.22, -0.22, 0.42), (0.22, 0.22, 0.46))
    back = box((-0.22, -0.22, 0.46), (0.22, -0.17, 0.95), omit=("-z",))
    builder.add(placed(np.concatenate([seat, back, _legs(0.42, 0.42, 0.42, 0.045)]), **pose), WALNUT)


def armchair(builder: SceneBuilder, **pose) -> None:
    """A low upholstered seat that looks along +y, 22 patches."""
    parts = [box((-0.295, -0.25, 0.1), (0.295, 0.45, 0.42), omit=("-y",)),
             box((-0.28, -0.25, 0.42), (0.28, 0.43, 0.5), omit=("-y", "-z")),
             box((-0.45, -0.45, 0.0), (0.45, -0.25, 0.85), omit=("-z",))]
    for side in (-0.45, 0.3):
        parts.append(box((side, -0.25, 0.0), (side + 0.15, 0.42, 0.6), omit=("-y", "-z")))
    builder.add(placed(np.concatenate(parts), **pose), CLOTH)


def bookshelf(builder: SceneBuilder, *, books, seed: int, **pose) -> None:
    """Shelves that look along +y, their open back at y = 0 against a wall; 24 patches and 5 a book.

    ``books`` says how many stand on each of the four shelves from the lowest up; ``seed`` gives their sizes and covers.
    """
    width, depth, height, board = 1.3, 0.32, 2.2, 0.03
    boards = [box((side, 0.0, 0.0), (side + board, depth, height), omit=("-y", "-z"))
              for side in (-width / 2, width / 2 - board)]
    levels = 0.08 + np.arange(5) * (height - 0.08 - board) / 4
    inner = width / 2 - board
    for level in levels:
        boards.append(box((-inner, 0.0, level), (inner, depth - 0.01, level + board), omit=("-x", "+x", "-y")))
    back = box((-inner, -1.0, 0.0), (inner, 0.01, height))[3:4]
    builder.add(placed(np.concatenate([*boards, back]), **pose), WALNUT)
    random = np.random.default_rng(seed)
    for level, count in zip(levels, books, strict=False):
        x = -inner + 0.02
        for thick, tall, deep, cover in zip(random.uniform(0.07, 0.13, count), random.uniform(0.28, 0.42, count),
                                            random.uniform(0.18, 0.26, count), random.integers(len(COVERS), size=count),
                                            strict=True):
            book = box((x, 0.03, level + board), (x + thick, 0.03 + deep, level + board + tall), omit=("-z",))
            builder.add(placed(book, **pose), COVERS[cover])
            x += thick + 0.004


def computer(builder: SceneBuilder, **pose) -> None:
    """A deep old screen on a foot, looking along +y, with a keyboard before it; 19 patches."""
    screen = box((-0.21, -0.22, 0.08), (0.21, 0.12, 0.44))
    front = screen[3]
    inset = np.mean(front, axis=0) + 0.84 * (front - np.mean(front, axis=0))
    frame = np.stack([front, np.roll(front, -1, axis=0), np.roll(inset, -1, axis=0), inset], axis=1)
    foot = box((-0.12, -0.16, 0.0), (0.12, 0.08, 0.08), omit=("-z", "+z"))
    keys = box((-0.22, 0.2, 0.0), (0.22, 0.37, 0.03), omit=("-z",))
    case = np.concatenate([screen[[0, 1, 2, 4, 5]], foot, keys])
    builder.add(placed(case, **pose), CASE)
    builder.add(placed(frame, **pose), CASE, surface=0)
    builder.add(placed(inset, **pose), DISPLAY)


def vase(builder: SceneBuilder, *, size: float, material: Material, **pose) -> None:
    """A turned vase of height ``size``, 64 patches."""
    profile = [(0.13, 0.0), (0.2, 0.14), (0.235, 0.34), (0.2, 0.56), (0.1, 0.78), (0.085, 0.88), (0.13, 1.0),
               (0.11, 0.99), (0.0, 0.8)]
    builder.add(placed(revolution(profile, segments=8), scale=(size,) * 3, **pose), material, smooth=True)


def plant(builder: SceneBuilder, *, leaves: int, size: float, seed: int, at) -> None:
    """A pot (24 patches) with earth (3) and ``leaves`` two-sided leaves that fan out of it to the height ``size``."""
    pot = revolution([(0.14, 0.0), (0.2, 0.34), (0.18, 0.34), (0.17, 0.28)], segments=8)
    builder.add(placed(pot, at=at), CLAY, smooth=True)
    rim = pot[-8:, 3]
    builder.add(placed(rim[[[0, 1, 2, 3], [0, 3, 4, 7], [4, 5, 6, 7]]], at=at), EARTH, surface=0)
    random = np.random.default_rng(seed)
    for turn, lean, long in zip(np.arange(leaves) * 137.5, np.linspace(0.1, 0.7, leaves),
                                random.uniform(0.75, 1.0, leaves) * (size - 0.3), strict=True):
        reach = long * np.array([0.0, np.sin(lean), np.cos(lean)])
        half = np.array([0.1 * long + 0.03, 0.0, 0.0])
        base = np.array([0.0, 0.03, 0.27])
        leaf = [base, base + 0.6 * reach + half, base + reach, base + 0.6 * reach - half]
        builder.add(placed(leaf, turn=turn, at=at), LEAF, two_sided=True)


def floor_lamp(builder: SceneBuilder, **pose) -> None:
    """A brass foot and pole (21 patches), a shade open at both ends (8) and a bulb (6 patches), switched off by day."""
    stand = revolution([(0.16, 0.0), (0.15, 0.03), (0.012, 0.05), (0.012, 1.52)], segments=7)
    builder.add(placed(stand, **pose), BRASS, smooth=True)
    shade = revolution([(0.26, 1.4), (0.15, 1.75)], segments=8)
    builder.add(placed(shade, **pose), SHADE, smooth=True, two_sided=True)
    builder.add(placed(box((-0.04, -0.04, 1.52), (0.04, 0.04, 1.62)), **pose), BULB)


def sheets(builder: SceneBuilder, *, count: int, seed: int, at) -> None:
    """Sheets of paper strewn around a point, each a two-sided patch lying a little above the last."""
    random = np.random.default_rng(seed)
    for k, (x, y, turn) in enumerate(random.uniform(-1.0, 1.0, (count, 3))):
        sheet = np.array([[-0.105, -0.15, 0.0], [0.105, -0.15, 0.0], [0.105, 0.15, 0.0], [-0.105, 0.15, 0.0]])
        centre = np.add(at, (0.4 * x, 0.2 * y, 0.002 * (k + 1)))
        builder.add(placed(sheet, turn=40.0 * turn, at=centre), PAPER, two_sided=True)
