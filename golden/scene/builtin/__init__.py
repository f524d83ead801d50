"""The registry of the built-in scenes, which are generated: one module per scene."""

from dataclasses import dataclass
from importlib import import_module

from golden.base.errors import InputError
from golden.scene.scene import Scene

__all__ = ["BUILTIN", "BuiltinScene", "builtin_scene"]


@dataclass(frozen=True)
class BuiltinScene:
    """A scene, made by the function of its name in the module of its name.

    ``sizes`` is the range of the size argument (what it counts is in ``about``) with the default, or None.
    """

    name: str
    about: str
    sizes: range | None = None
    default: int | None = None

    def make(self, size: int | None = None) -> Scene:
        """The scene, at ``size`` or its default size."""
        if self.sizes is None:
            if size is not None:
                raise InputError(f"scene {self.name!r}: it has one size, so {self.name}:{size} does not exist")
            arguments = ()
        else:
            size = self.default if size is None else size
            if size not in self.sizes:
                raise InputError(f"scene {self.name!r}: Size must be {self.sizes.start} to {self.sizes.stop - 1}, "
                                 f"not {size!r}")
            arguments = (size,)
        return getattr(import_module(f"golden.scene.builtin.{self.name}"), self.name)(*arguments)


BUILTIN = {scene.name: scene for scene in (
    BuiltinScene("cornell", "the Cornell box after its published measurements"),
    BuiltinScene("furnace", "closed cube that emits and reflects everywhere alike; size: patches along an edge",
                 range(1, 65), 8),
    BuiltinScene("lobby", "a hall of few large patches"),
    BuiltinScene("room1627", "the same hall with much small furniture"),
    BuiltinScene("cubes", "a regular array of boxes"),
    BuiltinScene("man", "an articulated figure"),
    BuiltinScene("phone", "a telephone with curved handset and keys"),
    BuiltinScene("city", "blocks, towers and streets in small facets, under the sky; size: plots along an edge",
                 range(1, 21), 6),
    BuiltinScene("teapot", "the 32 Bezier patches of Utah; size: cuts along a side", range(1, 65), 8),
    BuiltinScene("tetra", "SPD: pyramid of tetrahedra; size: levels", range(1, 10), 6),
    BuiltinScene("mountain", "SPD: fractal terrain with four glass balls; size: levels", range(1, 9), 5),
    BuiltinScene("rings", "SPD: pyramid of interlocking rings; size: rings along an edge", range(1, 9), 2),
    BuiltinScene("balls", "SPD: sphereflake; size: levels", range(0, 6), 2),
    BuiltinScene("gears", "SPD: interlocking gears; size: gears along an edge", range(1, 9), 2),
    BuiltinScene("tree", "SPD: branching tree; size: levels", range(0, 13), 7),
)}


def builtin_scene(spec: str) -> Scene:
    """The scene of a specification ``NAME`` or ``NAME:SIZE``.

    Raises
    ------
    InputError
        Unknown name, or a size that is not a number or out of the scene's range.
    """
    name, colon, size = spec.partition(":")
    if name not in BUILTIN:
        raise InputError(f"scene {spec!r}: no built-in scene has that name; there are {', '.join(BUILTIN)}")
    if colon and not (size.isascii() and size.isdigit() and len(size) <= 9):
        raise InputError(f"scene {spec!r}: Size must be a whole number, not {size!r}")
    return BUILTIN[name].make(int(size) if colon else None)
