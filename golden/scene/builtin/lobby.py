"""A hall of few large patches: the stand-in for the thesis' scene of that name."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import box, framed, placed
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import revolution

__all__ = ["CAMERA", "HEIGHT", "LENGTH", "WIDTH", "hall", "lobby"]

BAY = 4.0
HEIGHT = 4.4
LENGTH, WIDTH = 4 * BAY, 2 * BAY

PLASTER = Material(name="plaster", diffuse=(0.80, 0.78, 0.74))
WALL = Material(name="ochre wall", diffuse=(0.72, 0.58, 0.40))
LIGHT_STONE = Material(name="light stone", diffuse=(0.55, 0.51, 0.45), specular=(0.06, 0.06, 0.06))
DARK_STONE = Material(name="dark stone", diffuse=(0.26, 0.22, 0.20), specular=(0.06, 0.06, 0.06))
STEP = Material(name="step", diffuse=(0.62, 0.60, 0.56))
COLUMN = Material(name="column", diffuse=(0.74, 0.71, 0.66))
WOOD = Material(name="wood", diffuse=(0.38, 0.20, 0.10))
DARK_WOOD = Material(name="dark wood", diffuse=(0.20, 0.10, 0.05))
LEATHER = Material(name="leather", diffuse=(0.42, 0.08, 0.06))
BLUE_PICTURE = Material(name="blue picture", diffuse=(0.10, 0.22, 0.42))
YELLOW_PICTURE = Material(name="yellow picture", diffuse=(0.75, 0.52, 0.10))
LAMP = Material(name="lamp", diffuse=(0.60, 0.60, 0.60), emission=(15.0, 13.5, 11.0))
DAYLIGHT = Material(name="daylight", diffuse=(0.10, 0.10, 0.10), emission=(5.0, 6.2, 7.5))

CAMERA = Camera(eye=(0.7, 0.9, 1.75), target=(10.5, 4.6, 1.75), fov=52.0)


def lobby() -> Scene:
    """The hall, 16 x 8 x 4.4 m, closed; 227 patches."""
    builder = SceneBuilder("lobby")
    hall(builder)
    return builder.build(camera=CAMERA)


def hall(builder: SceneBuilder) -> None:
    """Adds the hall's 227 patches."""
    _shell(builder)
    for x in BAY, 2 * BAY, 3 * BAY:
        _column(builder, x, WIDTH / 2)
    _stairs(builder)
    _desk(builder)
    for x in 5.0, 9.0:
        _bench(builder, x, 6.9)
    # Doors and pictures stand off the walls; their backs are left out.
    builder.add(box((15.9, 3.3, 0.6), (16.0, 4.7, 3.0), omit=("+x", "-z")), DARK_WOOD)
    for x in 5.4, 6.5:
        builder.add(box((x, 0.0, 0.0), (x + 1.05, 0.08, 2.5), omit=("-y", "-z")), DARK_WOOD)
    builder.add(box((15.95, 0.9, 1.5), (16.0, 2.3, 2.9), omit=("+x",)), YELLOW_PICTURE)
    builder.add(box((15.95, 5.7, 1.5), (16.0, 7.1, 2.9), omit=("+x",)), BLUE_PICTURE)
    builder.add(box((9.0, 0.0, 1.4), (11.0, 0.05, 2.8), omit=("-y",)), BLUE_PICTURE)


def _shell(builder: SceneBuilder) -> None:
    """Floor, ceiling and walls in bays that meet corner to corner."""
    for i, x in enumerate(np.arange(4) * BAY):
        for j, y in enumerate(np.arange(2) * BAY):
            floor, ceiling = box((x, y, 0.0), (x + BAY, y + BAY, HEIGHT))[[4, 5], ::-1]
            builder.add(floor, (LIGHT_STONE, DARK_STONE)[(i + j) % 2])
            _panelled(builder, framed(ceiling, border=1.35), PLASTER, LAMP)
        front, back = box((x, 0.0, 0.0), (x + BAY, WIDTH, HEIGHT))[[2, 3], ::-1]
        builder.add(front, WALL)
        _panelled(builder, framed(back, border=0.9, depth=0.25), PLASTER, DAYLIGHT)
    for y in np.arange(2) * BAY:
        builder.add(box((0.0, y, 0.0), (LENGTH, y + BAY, HEIGHT))[:2, ::-1], PLASTER)


def _panelled(builder: SceneBuilder, patches: np.ndarray, around: Material, panel: Material) -> None:
    """Adds what `framed` made: the frame is one surface, the sides of the recess and the panel are their own."""
    builder.add(patches[:4], around, surface=0)
    # Dark sides do not glare beside their own light.
    builder.add(patches[4:-1], DARK_WOOD)
    builder.add(patches[-1], panel)


def _column(builder: SceneBuilder, x: float, y: float) -> None:
    """An octagonal column between a plinth and a capital."""
    builder.add(box((x - 0.4, y - 0.4, 0.0), (x + 0.4, y + 0.4, 0.3), omit=("-z",)), COLUMN)
    builder.add(placed(revolution([(0.3, 0.3), (0.3, HEIGHT - 0.25)], segments=8), at=(x, y, 0.0)), COLUMN, smooth=True)
    builder.add(box((x - 0.4, y - 0.4, HEIGHT - 0.25), (x + 0.4, y + 0.4, HEIGHT), omit=("+z",)), COLUMN)


def _stairs(builder: SceneBuilder) -> None:
    """Four steps against the far wall, a riser, a tread and two cheeks each."""
    for level in range(4):
        near, far = 13.6 + 0.4 * level, 14.0 + 0.4 * level if level < 3 else LENGTH
        step = box((near, 2.6, 0.0), (far, 5.4, 0.15 * (level + 1)), omit=("-x", "+x", "-z"))
        riser = box((near, 2.6, 0.15 * level), (far, 5.4, 0.15 * (level + 1)))[:1]
        builder.add(np.concatenate([riser, step]), STEP)


def _desk(builder: SceneBuilder) -> None:
    """The reception: a body under a slab that juts out."""
    builder.add(box((8.6, 1.3, 0.0), (11.4, 2.0, 1.05), omit=("-z", "+z")), WOOD)
    builder.add(box((8.5, 1.2, 1.05), (11.5, 2.15, 1.12)), DARK_STONE)


def _bench(builder: SceneBuilder, x: float, y: float) -> None:
    """A seat on two blocks."""
    builder.add(box((x, y, 0.36), (x + 2.0, y + 0.55, 0.48)), LEATHER)
    for foot in x + 0.2, x + 1.6:
        builder.add(box((foot, y + 0.08, 0.0), (foot + 0.2, y + 0.47, 0.36), omit=("-z", "+z")), DARK_WOOD)
