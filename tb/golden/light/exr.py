"""Pictures of linear radiance, read again."""

import OpenEXR

__all__ = ["read_exr"]


def read_exr(path):
    """H x W x 3 float32 of an OpenEXR file with the channels R, G, B."""
    return OpenEXR.File(str(path)).channels()["RGB"].pixels
