"""The lobby with much small furniture: the stand-in for the thesis' scene room16.27."""

from golden.scene.builder import SceneBuilder
from golden.scene.builtin import furniture
from golden.scene.builtin.lobby import hall
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["room1627"]

GLAZE = Material(name="blue glaze", diffuse=(0.10, 0.20, 0.45), specular=(0.05, 0.05, 0.05))
WHITE_GLAZE = Material(name="white glaze", diffuse=(0.75, 0.75, 0.72), specular=(0.05, 0.05, 0.05))
RUG = Material(name="rug", diffuse=(0.40, 0.10, 0.09))


def room1627() -> Scene:
    """The same hall, crowded in the corner at the origin; 1297 patches of which the lobby's come first."""
    builder = SceneBuilder("room1627")
    hall(builder)
    _library(builder)
    _study(builder)
    _reception(builder)
    _waiting(builder)
    return builder.build(camera=Camera(eye=(8.1, 3.3, 1.9), target=(1.5, 2.9, 1.25), fov=54.0))


def _library(builder: SceneBuilder) -> None:
    """Full shelves along both walls of the corner."""
    for number, x in enumerate((1.3, 2.7)):
        furniture.bookshelf(builder, books=(7, 6, 8, 5), seed=number, at=(x, 0.0, 0.0))
    for number, y in enumerate((1.3, 2.7)):
        furniture.bookshelf(builder, books=(6, 7, 5, 4), seed=10 + number, at=(0.0, y, 0.0), turn=-90.0)


def _study(builder: SceneBuilder) -> None:
    """Tables between the shelves, with what lies on them."""
    builder.add(box((1.0, 1.1, 0.0), (4.6, 3.4, 0.012), omit=("-z",)), RUG)
    furniture.table(builder, width=2.0, depth=1.0, at=(2.3, 2.1, 0.012))
    for x, y, turn in ((1.8, 1.4, 0.0), (2.8, 1.38, 8.0), (1.8, 2.85, 180.0), (2.85, 2.9, 165.0)):
        furniture.chair(builder, at=(x, y, 0.012), turn=turn)
    furniture.sheets(builder, count=11, seed=3, at=(2.0, 2.1, 0.752))
    furniture.vase(builder, size=0.36, material=GLAZE, at=(2.95, 2.2, 0.752))
    furniture.floor_lamp(builder, at=(0.45, 0.45, 0.0))
    furniture.plant(builder, leaves=14, size=1.5, seed=5, at=(0.8, 3.6, 0.0))


def _reception(builder: SceneBuilder) -> None:
    """Computers and papers on the hall's desk."""
    for x in 9.3, 10.6:
        furniture.computer(builder, at=(x, 1.75, 1.12), turn=180.0)


def _waiting(builder: SceneBuilder) -> None:
    """Armchairs around a low table by the windows."""
    furniture.table(builder, width=0.9, depth=0.6, height=0.42, at=(2.2, 5.9, 0.0))
    furniture.vase(builder, size=0.3, material=WHITE_GLAZE, at=(2.4, 5.95, 0.42))
    furniture.armchair(builder, at=(1.0, 5.6, 0.0), turn=-90.0)
    furniture.armchair(builder, at=(2.2, 7.1, 0.0), turn=180.0)
    furniture.plant(builder, leaves=13, size=1.4, seed=6, at=(0.9, 7.1, 0.0))
