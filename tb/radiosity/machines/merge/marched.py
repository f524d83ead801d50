"""Small volumes, and rays that march through all their tetrahedra by brute force."""

from functools import cache

import numpy as np

from radiosity.machines.merge.screen_volume import drawn_direction, view_volume
from radiosity.machines.merge.tetrahedra import blunt_fin
from radiosity.machines.merge.z_list import transferred

__all__ = ["marched", "small_volume"]


@cache
def small_volume(seed, *, sides=(6, 5, 4), size=32):
    """A blunt fin and its view on a square screen."""
    volume = blunt_fin(sides, seed=seed)
    return volume, view_volume(volume, drawn_direction(seed), size, size)


def marched(volume, screen):
    """H x W x 4: each ray clipped by the planes of each cell, its samples composed from back to front."""
    points = screen.points[volume.cells]
    y, x = np.divmod(np.arange(screen.width * screen.height), screen.width)
    samples = [[] for _ in x]
    for corners, values in zip(points, screen.values[volume.cells], strict=True):
        low, high = np.full(len(x), -np.inf), np.full(len(x), np.inf)
        for without in range(4):
            a, b, c = np.delete(corners, without, axis=0)
            normal = np.cross(b - a, c - a)
            normal *= np.sign(normal @ (corners[without] - a))
            # Inside where the distance from the plane, offset + slope z, is positive.
            offset, slope = (x - a[0]) * normal[0] + (y - a[1]) * normal[1] - a[2] * normal[2], normal[2]
            if slope > 0:
                low = np.maximum(low, -offset / slope)
            elif slope < 0:
                high = np.minimum(high, -offset / slope)
        for ray in np.flatnonzero(low < high):
            middle = (low[ray] + high[ray]) / 2
            weight = 1 / np.linalg.norm(corners - (x[ray], y[ray], middle), axis=1)
            samples[ray].append((middle, weight @ values / weight.sum()))
    picture = np.zeros((len(x), 4))
    for ray, found in enumerate(samples):
        colour, through = np.zeros(3), 1.0
        for _, value in sorted(found, reverse=True):
            red, green, blue, opacity = transferred(value)
            colour = colour * (1 - opacity) + np.array([red, green, blue]) * opacity
            through *= 1 - opacity
        picture[ray] = *colour, 1 - through
    return picture.reshape(screen.height, screen.width, 4)
