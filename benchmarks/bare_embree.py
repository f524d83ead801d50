"""Embree's own interface in single precision: how fast `golden.cast.embree.Embree` could be at most."""

import ctypes

import numpy as np

from golden.base.compiled import compiled
from golden.base.native import call
from golden.cast.embree_library import embree_library
from golden.cast.embree_scene import EmbreeScene
from golden.cast.rays import Rays
from golden.scene.scene import Scene

__all__ = ["LANES", "BareEmbree"]

# Where rays start, in the scene's sizes: behind their sources.
NEAR = 2.0**-19
# Rays of a call.
LANES = 8


class BareEmbree:
    """The patches that rays meet as Embree has them: in single precision, with a robust scene, and own patches ahead.

    8 rays are cast at a time, as many as AVX2 has lanes for.

    Parameters
    ----------
    scene
        The patches.
    """

    def __init__(self, scene: Scene):
        library, self._scene = embree_library(), scene
        self._centre = scene.bounds.mean(axis=0)
        self._held = EmbreeScene((scene.vertices - self._centre) / scene.size)
        self._queries = [ctypes.cast(query, ctypes.c_void_p).value
                         for query in (library.rtcIntersect8, library.rtcOccluded8)]

    def prepared(self, rays: Rays) -> tuple[np.ndarray, np.ndarray]:
        """Origins and unit directions as Embree takes them, R x 3 float32; R is cut to a multiple of `LANES`."""
        count = len(rays) // LANES * LANES
        length = np.linalg.norm(rays.direction[:count], axis=1, keepdims=True)
        return (((rays.origin[:count] - self._centre) / self._scene.size).astype(np.float32),
                (rays.direction[:count] / length).astype(np.float32))

    def cast(self, origin: np.ndarray, direction: np.ndarray, *, any_hit: bool) -> np.ndarray:
        """The number of the patch that each ray meets first, R int32, or -1; of any hit, 0 or -1."""
        patch = np.empty(len(origin), dtype=np.int32)
        _cast(self._queries[any_hit], any_hit, self._held.address, np.float32(NEAR), origin, direction, patch)
        return patch


@compiled
def _cast(query, any_hit, scene, near, origin, direction, patch_of):
    """Cast rays, `LANES` at a time."""
    memory = np.zeros(24 * LANES + 32, dtype=np.float32)
    first = (-memory.ctypes.data) % 64 // 4
    valid = memory[first:first + LANES].view(np.int32)
    packet = memory[first + 16:first + 16 + 21 * LANES].reshape(21, LANES)
    bits = packet.view(np.uint32)
    valid[:] = -1
    none, endless = np.uint32(0xFFFFFFFF), np.float32(np.inf)
    for begin in range(0, len(origin), LANES):
        for lane in range(LANES):
            row = begin + lane
            for axis in range(3):
                packet[axis, lane], packet[4 + axis, lane] = origin[row, axis], direction[row, axis]
            packet[3, lane], packet[7, lane], packet[8, lane] = near, np.float32(0), endless
            bits[9, lane], bits[10, lane], bits[11, lane] = none, 0, 0
            bits[18, lane], bits[19, lane] = none, none
        call(query, (valid.ctypes.data, np.uintp(scene), packet.ctypes.data, np.uintp(0)))
        for lane in range(LANES):
            if any_hit:
                patch_of[begin + lane] = 0 if packet[8, lane] < 0 else -1
            else:
                patch_of[begin + lane] = np.int32(bits[17, lane]) if bits[18, lane] != none else -1
