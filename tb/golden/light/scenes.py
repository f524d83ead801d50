"""Small scenes for tests of light."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["BLACK", "rectangle", "scene_of"]

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
