"""Quadrilaterals in Embree's memory, with its hierarchy of boxes."""

import weakref
from functools import cache

import numpy as np

from golden.cast.embree_library import embree_library

__all__ = ["EmbreeScene"]

# Of the C interface.
_ROBUST, _QUADS, _CORNERS, _INDICES, _FLOAT3, _UINT4 = 1 << 2, 1, 1, 0, 0x9003, 0x5004


class EmbreeScene:
    """A scene of quadrilaterals, numbered as they are given.

    Parameters
    ----------
    quads
        N x 4 x 3 float. Each is the triangles (0, 1, 2) and (0, 2, 3).

    Members
    -------
    address
        The one that the C interface takes.

    Raises
    ------
    ModuleNotFoundError
        There is no wheel of embreex.
    MemoryError
        Embree has no memory for the scene.
    """

    def __init__(self, quads: np.ndarray):
        library, device, count = embree_library(), _device(), len(quads)
        # Embree cuts along the diagonal 1 3, and reads 16 bytes of each corner.
        self._corners = np.zeros(12 * count + 1, dtype=np.float32)
        self._corners[:-1] = quads[:, [1, 2, 3, 0]].reshape(-1)
        self._indices = np.arange(4 * count, dtype=np.uint32)
        self.address = library.rtcNewScene(device)
        weakref.finalize(self, library.rtcReleaseScene, self.address)
        library.rtcSetSceneFlags(self.address, _ROBUST)
        geometry = library.rtcNewGeometry(device, _QUADS)
        for kind, form, values, size in ((_CORNERS, _FLOAT3, self._corners, 12), (_INDICES, _UINT4, self._indices, 16)):
            library.rtcSetSharedGeometryBuffer(geometry, kind, 0, form, values.ctypes.data, 0, size,
                                               4 * count if kind == _CORNERS else count)
        library.rtcCommitGeometry(geometry)
        library.rtcAttachGeometry(self.address, geometry)
        library.rtcReleaseGeometry(geometry)
        library.rtcCommitScene(self.address)
        if library.rtcGetDeviceError(device):
            raise MemoryError(f"Embree cannot hold {count} patches")


@cache
def _device():
    """Embree's device of this process; one thread builds a scene, so that each time it is the same."""
    return embree_library().rtcNewDevice(b"threads=1")
