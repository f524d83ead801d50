"""A furnished room of any number of patches: the stand-in for the lost scenes of Kurc's tables."""

from golden.scene.builder import SceneBuilder
from golden.scene.builtin import furniture
from golden.scene.builtin.shapes import box
from golden.scene.halve import halved
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["furnished_room"]

WIDTH, DEPTH, HEIGHT = 5.0, 4.0, 2.7

WALL = Material(name="wall", diffuse=(0.70, 0.66, 0.58))
CEILING = Material(name="ceiling", diffuse=(0.80, 0.80, 0.78))
FLOOR = Material(name="floor", diffuse=(0.40, 0.30, 0.20))
WOOD = Material(name="wood", diffuse=(0.45, 0.28, 0.14))
LAMP = Material(name="lamp", diffuse=(0.60, 0.60, 0.60), emission=(15.0, 13.5, 11.0))


def furnished_room(patches: int) -> Scene:
    """A room, 5 x 4 x 2.7 m, with a table, chairs, armchairs, cabinets, shelves and a lamp.

    Parameters
    ----------
    patches
        At least the 248 of the room and its furniture, the largest of which are halved, see `halved`.

    Raises
    ------
    InputError
        There are fewer.
    """
    builder = SceneBuilder("furnished room")
    walls = box((0, 0, 0), (WIDTH, DEPTH, HEIGHT))[:, ::-1]
    builder.add(walls[:4], WALL)
    builder.add(walls[4], FLOOR)
    builder.add(walls[5], CEILING)
    builder.add(box((1.8, 1.4, 2.6), (3.2, 2.6, HEIGHT), omit=("+z",)), LAMP)
    furniture.table(builder, width=1.6, depth=0.9, at=(2.5, 1.8, 0))
    for x, y, turn in ((2.1, 1.2, 0.0), (2.9, 1.2, 0.0), (2.1, 2.45, 180.0), (2.9, 2.45, 180.0)):
        furniture.chair(builder, at=(x, y, 0), turn=turn)
    furniture.armchair(builder, at=(0.7, 3.2, 0), turn=-120.0)
    furniture.armchair(builder, at=(4.2, 3.3, 0), turn=130.0)
    furniture.bookshelf(builder, books=(), seed=0, at=(1.0, 0, 0))
    furniture.bookshelf(builder, books=(), seed=0, at=(4.2, 0, 0))
    for lower, upper in (((0, 0.8, 0), (0.5, 2.2, 2.0)), ((4.45, 1.0, 0), (WIDTH, 2.6, 1.1)),
                         ((1.9, 3.5, 0), (3.3, DEPTH, 0.8))):
        builder.add(box(lower, upper, omit=("-z",)), WOOD)
    return halved(builder.build(), patches)
