"""The unit cube seen from inside, for tests that know its light."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.material import Material

__all__ = ["FACES", "cube"]

# A corner and the two edges of each face; their cross product points inwards.
FACES = {
    "floor": ((0, 0, 0), (1, 0, 0), (0, 1, 0)),
    "ceiling": ((0, 0, 1), (0, 1, 0), (1, 0, 0)),
    "left": ((0, 0, 0), (0, 1, 0), (0, 0, 1)),
    "right": ((1, 0, 0), (0, 0, 1), (0, 1, 0)),
    "front": ((0, 0, 0), (0, 0, 1), (1, 0, 0)),
    "back": ((0, 1, 0), (1, 0, 0), (0, 0, 1)),
}


def cube(cuts):
    """A closed cube of ``cuts`` x ``cuts`` patches a face, faces in the order of `FACES`; each face is one surface."""
    builder = SceneBuilder("cube")
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    cell = (np.stack(np.mgrid[:cuts, :cuts], axis=-1)[:, :, None] + corners).reshape(-1, 4, 2) / cuts
    for name, (corner, along, up) in FACES.items():
        patches = np.array(corner) + cell[..., :1] * np.array(along) + cell[..., 1:] * np.array(up)
        builder.add(patches, Material(name=name), surface=0)
    return builder.build()
