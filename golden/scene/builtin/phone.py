"""A desk telephone: the stand-in for the thesis' scene of that name."""

import numpy as np
from scipy.interpolate import CubicSpline

from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import box, cap, framed, frames, loft, placed, rounded, tube
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import revolution

__all__ = ["phone"]

RED = Material(name="red plastic", diffuse=(0.48, 0.05, 0.04), specular=(0.04, 0.04, 0.04))
BLACK = Material(name="black rubber", diffuse=(0.04, 0.04, 0.045))
IVORY = Material(name="ivory key", diffuse=(0.72, 0.68, 0.58))
GREY = Material(name="grey key", diffuse=(0.30, 0.30, 0.32))
PRINT = Material(name="print", diffuse=(0.03, 0.03, 0.03))
DISPLAY = Material(name="display", diffuse=(0.36, 0.44, 0.26))
DESK = Material(name="desk", diffuse=(0.42, 0.26, 0.14))
PLASTER = Material(name="plaster", diffuse=(0.72, 0.72, 0.68))
BACK_WALL = Material(name="back wall", diffuse=(0.28, 0.42, 0.46))
LIGHT = Material(name="light", diffuse=(0.60, 0.60, 0.60), emission=(14.0, 13.0, 11.0))
PAPER = Material(name="paper", diffuse=(0.84, 0.83, 0.78))
GLAZE = Material(name="white glaze", diffuse=(0.76, 0.76, 0.74), specular=(0.05, 0.05, 0.05))
COFFEE = Material(name="coffee", diffuse=(0.06, 0.03, 0.015), specular=(0.04, 0.04, 0.04))
LACQUER = Material(name="yellow lacquer", diffuse=(0.72, 0.50, 0.06))
TIP = Material(name="pencil tip", diffuse=(0.60, 0.45, 0.28))

# Centimetres. The top of the body rises to the back by SLOPE; TOP is its height in the middle.
WIDTH, DEPTH, TOP, SLOPE = 21.0, 22.0, 5.75, 0.2
HANDSET = -6.2
# Strokes of a character as on a seven-segment display, from the top clockwise, the middle one last.
STROKES = {"0": "012345", "1": "12", "2": "01643", "3": "01236", "4": "1256", "5": "02356", "6": "023456", "7": "012",
           "8": "0123456", "9": "012356", "*": "0156", "#": "12456"}


def phone() -> Scene:
    """A telephone with its coiled cord on a desk in a closed niche, with a cup, paper and a pencil; 4103 patches."""
    builder = SceneBuilder("phone")
    _niche(builder)
    _body(builder)
    _keys(builder)
    _display(builder)
    _handset(builder)
    _cord(builder)
    _things(builder)
    return builder.build(camera=Camera(eye=(10.0, -40.0, 33.0), target=(1.0, -2.0, 2.0), fov=47.0))


def _tilted(patches) -> np.ndarray:
    """From heights above the body's top to the scene. A shear, so what is planar stays so."""
    patches = np.array(patches, dtype=np.float64)
    patches[..., 2] += TOP + SLOPE * patches[..., 1]
    return patches


def _niche(builder: SceneBuilder) -> None:
    """Desk top, walls, and a ceiling with a light; the neighbours share their corners."""
    left, right, front, back, desk, ceiling = box((-48.0, -44.0, 0.0), (48.0, 34.0, 62.0))[:, ::-1]
    builder.add([left, right, front], PLASTER)
    builder.add(back, BACK_WALL)
    builder.add(desk, DESK)
    panel = framed(ceiling, border=24.0)
    builder.add(panel[:4], PLASTER, surface=0)
    builder.add(panel[4], LIGHT)


def _body(builder: SceneBuilder) -> None:
    """A wedge with round edges on four feet, and pads for the handset's cups."""
    steps = 5
    foot = rounded(WIDTH - 1.0, DEPTH - 1.0, radius=1.5, steps=steps, height=0.3)
    waist = rounded(WIDTH, DEPTH, radius=2.0, steps=steps, height=1.0)
    fillet = [_tilted(rounded(WIDTH - inset, DEPTH - inset, radius=2.0 - inset / 2, steps=steps, height=-drop))
              for inset, drop in ((0.0, 1.0), (0.27, 0.5), (0.73, 0.13), (1.4, 0.0))]
    # The walls stand upright and the rings of each group are parallel: all quads are planar.
    builder.add(loft([foot, waist, *fillet]), RED, smooth=True)
    for ends in cap(foot[::-1]), cap(fillet[-1]):
        builder.add(ends, RED, surface=0)
    for x in -8.0, 8.0:
        for y in -8.5, 8.5:
            builder.add(placed(revolution([(0.7, 0.0), (0.8, 0.3)], segments=10), at=(x, y, 0.0)), BLACK, smooth=True)
    for y in -8.2, 8.2:
        pad = revolution([(2.1, 0.0), (2.0, 0.25), (0.0, 0.25)], segments=16)
        builder.add(_tilted(placed(pad, at=(HANDSET, y, 0.0))), BLACK)
    for x in 5.6 + 0.55 * np.arange(7):
        slot = box((x, -9.7, 0.0), (x + 0.3, -8.3, 0.02))[5]
        builder.add(_tilted(slot), BLACK)


def _keys(builder: SceneBuilder) -> None:
    """Twelve digits with their print, and two groups of smaller keys."""
    for number, name in enumerate("123456789*0#"):
        centre = (-0.6 + 2.6 * (number % 3), 0.0 - 2.4 * (number // 3), 0.0)
        _key(builder, centre, (2.0, 1.7, 0.6), steps=2, material=IVORY)
        builder.add(_tilted(_stroked(name, 0.8) + np.add(centre, (0.0, 0.0, 0.61))), PRINT)
    for row in range(5):
        _key(builder, (8.0, 0.0 - 1.8 * row, 0.0), (1.9, 1.1, 0.45), steps=1, material=GREY)
    for column in range(5):
        _key(builder, (-0.9 + 2.25 * column, 2.5, 0.0), (1.7, 0.9, 0.4), steps=1, material=GREY)


def _key(builder: SceneBuilder, centre, size, *, steps: int, material: Material) -> None:
    width, depth, height = size
    rings = [rounded(width - inset, depth - inset, radius=0.4 - inset / 2, steps=steps, height=z)
             for inset, z in ((0.0, 0.0), (0.2, height - 0.12), (0.45, height))]
    for patches in loft(rings), cap(rings[-1]):
        builder.add(_tilted(patches + np.asarray(centre)), material)


def _stroked(text: str, height: float) -> np.ndarray:
    """Characters of straight strokes side by side around the origin."""
    half, thick = height / 2, 0.08 * height
    across, long = 0.28 * height, (half - thick) / 2
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    flat, upright = corners * (across - 1.3 * thick, thick), corners * (thick, long)
    offsets = np.array([(0, half), (across, half / 2), (across, -half / 2), (0, -half), (-across, -half / 2),
                       (-across, half / 2), (0, 0)])
    strokes = []
    for number, character in enumerate(text):
        shift = (number - (len(text) - 1) / 2) * height, 0.0
        for stroke in map(int, STROKES[character]):
            strokes.append((flat if stroke in (0, 3, 6) else upright) + offsets[stroke] + shift)
    return np.concatenate([strokes, np.zeros((len(strokes), 4, 1))], axis=-1)


def _display(builder: SceneBuilder) -> None:
    """A case with a glass let into it, which shows a number."""
    case = box((-2.0, 4.4, 0.0), (9.2, 9.4, 0.9), omit=("-z",))
    front = framed(case[-1], border=0.5, depth=0.15)
    builder.add(_tilted(np.concatenate([case[:-1], front[4:8]])), BLACK)
    builder.add(_tilted(front[:4]), BLACK, surface=0)
    builder.add(_tilted(front[8]), DISPLAY)
    builder.add(_tilted(np.add(_stroked("2271297", 1.2), (3.6, 6.9, 0.76))), PRINT)


def _handset(builder: SceneBuilder) -> None:
    """A grip bent in a circle around an axis along x (so its quads are planar) with a cup at each end."""
    middle, sag, half = 4.3, 1.9, 8.2
    bend = (half**2 + sag**2) / (2 * sag)
    section = rounded(3.6, 2.1, radius=0.9, steps=3)
    angle = np.arcsin(half / bend) * np.linspace(-1.0, 1.0, 17)[:, None]
    reach = bend + section[:, 1]
    rings = np.stack([np.broadcast_to(section[:, 0], (17, len(section))), reach * np.sin(angle),
                      middle - bend + reach * np.cos(angle)], axis=-1)
    builder.add(_tilted(np.add(loft(rings[::-1]), (HANDSET, 0.0, 0.0))), RED, smooth=True)
    cup = revolution([(0.0, 0.3), (1.9, 0.3), (2.4, 0.45), (2.65, 0.9), (2.7, 1.6), (2.6, 2.4), (2.25, 3.05),
                      (1.5, 3.45), (0.0, 3.6)], segments=24)
    for y in -half, half:
        builder.add(_tilted(placed(cup, at=(HANDSET, y, 0.0))), RED, smooth=True)


def _cord(builder: SceneBuilder) -> None:
    """A wire from the handset's mouthpiece over the desk into the body's side, coiled but for its ends."""
    spine = np.array([(HANDSET, -9.6, 5.1), (HANDSET - 0.2, -12.6, 4.6), (-7.2, -16.0, 1.9), (-10.5, -18.6, 1.55),
                      (-15.5, -16.5, 1.55), (-18.0, -9.5, 1.55), (-16.5, -2.0, 1.55), (-13.5, 3.0, 1.6),
                      (-9.5, 5.0, 1.9)])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(spine, axis=0), axis=1))])
    turns, pieces = 26, 243
    along = np.linspace(0.0, 1.0, pieces + 1)
    path = CubicSpline(length / length[-1], spine)(along)
    right, up = frames(path)
    size = 1.1 * np.clip(np.minimum(along - 0.06, 0.95 - along) / 0.06, 0.0, 1.0)[:, None]
    phase = 2 * np.pi * turns * along[:, None]
    coil = path + size * (np.cos(phase) * right + np.sin(phase) * up)
    builder.add(tube(coil, radius=0.34, sides=5), RED, smooth=True)


def _things(builder: SceneBuilder) -> None:
    """A cup of coffee, a pad of paper and a pencil."""
    cup = revolution([(2.6, 0.0), (3.6, 1.2), (3.9, 3.5), (4.0, 7.5), (3.75, 7.5), (3.6, 4.0)], segments=20)
    builder.add(placed(cup, at=(18.5, 13.5, 0.0)), GLAZE, smooth=True)
    angle = 2 * np.pi * np.arange(20) / 20
    coffee = cap(np.stack([3.75 * np.cos(angle), 3.75 * np.sin(angle), np.full(20, 6.6)], axis=-1))
    builder.add(placed(coffee, at=(18.5, 13.5, 0.0)), COFFEE, surface=0)
    pad = box((-5.0, -7.0, 0.0), (5.0, 7.0, 0.8), omit=("-z",))
    builder.add(placed(pad, turn=-14.0, at=(19.0, -6.0, 0.0)), PAPER)
    pose = {"axis": (0.55, 0.9, 0.0), "at": (16.5, -11.0, 1.2)}
    builder.add(placed(revolution([(0.0, -0.1), (0.35, 0.0), (0.35, 9.0)], segments=6), **pose), LACQUER)
    builder.add(placed(revolution([(0.35, 9.0), (0.0, 10.4)], segments=6), **pose), TIP)
