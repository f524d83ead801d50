"""Projection work: how long a node takes to project patches on the hemicube of a row."""

from functools import cached_property

import numpy as np

from golden.base.compiled import compiled
from golden.cast.frame import frame
from golden.scene.scene import Scene
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.node_memory import SIDE, SQUARES

__all__ = ["ProjectionWork"]


class ProjectionWork:
    """Nanoseconds of the rows of a scene.

    A patch that faces the hemicube's centre, or is two-sided, is compared with the horizon. One that has a corner above
    it is compared with the faces, and projected on those in whose direction it has a corner. Its squares are scanned,
    whether another patch hides them or not. The source has no number of squares. Ours is the solid angle of a disc of
    the patch's area, seen from its axis and turned by the patch's angle, over that of a square in the direction of its
    centre.

    Parameters
    ----------
    scene
        The patches.
    timing
        Operations of a hemicube.

    Source: Kurc 1997, section 2.4.1, for what depends on the patch.
    """

    def __init__(self, scene: Scene, timing: NodeTiming):
        self.timing, self._scene = timing, scene
        self._numbers = np.array([timing.visibility, timing.horizon, timing.clipping, timing.projection,
                                  timing.square], dtype=np.int64)

    @property
    def clearing(self) -> int:
        """Ns before the first projection of a row."""
        return SQUARES * self.timing.clearing * self.timing.operation

    @property
    def summing(self) -> int:
        """Ns after its last projection."""
        return SQUARES * self.timing.summing * self.timing.operation

    def of_blocks(self, block: np.ndarray, blocks: int) -> np.ndarray:
        """Ns to project each block of patches on the hemicube of each patch.

        Parameters
        ----------
        block
            N int: the block of each patch.
        blocks
            B.

        Returns
        -------
        N x B int64.
        """
        scene, operations = self._scene, np.zeros((len(block), blocks), dtype=np.int64)
        _count(scene.centres, scene.normals, frame(scene.normals), scene.vertices, scene.areas, scene.two_sided,
               np.asarray(block, dtype=np.int64), self._numbers, operations)
        return operations * self.timing.operation

    @cached_property
    def of_rows(self) -> np.ndarray:
        """N int64: ns of each row, if its node has all patches."""
        count = len(self._scene)
        return self.clearing + self.of_blocks(np.zeros(count, dtype=np.int64), 1)[:, 0] + self.summing


@compiled
def _count(centres, normals, frames, vertices, areas, two_sided, block, numbers, operations):
    """Operations of the projections of each block, by row."""
    visibility, horizon, clipping, projection, square = numbers
    to, local = np.zeros(3), np.zeros(3)
    for row in range(len(centres)):
        frame_of_row = frames[row]
        for patch in range(len(centres)):
            for axis in range(3):
                to[axis] = centres[patch, axis] - centres[row, axis]
            found = visibility
            facing = -(to[0] * normals[patch, 0] + to[1] * normals[patch, 1] + to[2] * normals[patch, 2])
            if patch != row and (facing > 0 or two_sided[patch]):
                met = 0
                for corner in range(4):
                    met |= _face(vertices[patch, corner], centres[row], frame_of_row, local)
                found += horizon + clipping * (met > 0)
                for face in range(5):
                    found += projection * (met >> face & 1)
                if _face(centres[patch], centres[row], frame_of_row, local):
                    far = np.sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2])
                    angle = 2 * np.pi * (1 - far / np.sqrt(far * far + areas[patch] / np.pi)) * abs(facing) / far
                    # Half an edge has `SIDE` squares; a square's solid angle is depth^3 / `SIDE`^2.
                    depth = max(abs(local[0]), abs(local[1]), local[2]) / far
                    found += square * min(SQUARES, int(angle * SIDE * SIDE / depth ** 3))
            operations[row, block[patch]] += found


@compiled
def _face(point, centre, frame_of_row, local):
    """A bit for the hemicube's face in whose direction a point is, 0 below the horizon; sets its coordinates there."""
    for axis in range(3):
        local[axis] = ((point[0] - centre[0]) * frame_of_row[axis, 0] + (point[1] - centre[1]) * frame_of_row[axis, 1]
                       + (point[2] - centre[2]) * frame_of_row[axis, 2])
    if local[2] <= 0:
        return 0
    x, y = abs(local[0]), abs(local[1])
    if local[2] >= x and local[2] >= y:
        return 1
    if x >= y:
        return 2 if local[0] > 0 else 4
    return 8 if local[1] > 0 else 16
