"""Small scenes for tests of light."""

import numpy as np

from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.light.indirect import indirect_light
from golden.light.tally import Tally
from golden.scene.builder import SceneBuilder
from golden.scene.material import Material
from golden.scene.refine import refine
from golden.scene.scene import Scene

__all__ = ["BLACK", "rectangle", "scene_of", "solved"]

BLACK = Material(name="black")


def rectangle(corner, along, up) -> np.ndarray:
    """A parallelogram, 4 x 3, with its front where ``along`` x ``up`` points."""
    corner, along, up = (np.array(vector, dtype=float) for vector in (corner, along, up))
    return np.array([corner, corner + along, corner + along + up, corner + up])


def scene_of(*parts, **properties) -> Scene:
    """A scene of parts: patches, their material, and if need be a dictionary of options of `SceneBuilder.add`."""
    builder = SceneBuilder("test")
    for patches, material, *options in parts:
        builder.add(patches, material, **(options[0] if options else {}))
    return builder.build(**properties)


def solved(scene, max_edge=0.17):
    """The light of a scene's elements."""
    caster = Grid(scene)
    return indirect_light(scene, refine(scene, max_edge=max_edge), caster, caster, Tally(),
                          hemisphere=Hemisphere(64, 16), solver="conjugate-gradient", light_samples=16, seed=0)
