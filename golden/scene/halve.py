"""Patches cut in halves, the largest first, until a scene has a number of them."""

import heapq

import numpy as np

from golden.base.errors import InputError, check_int
from golden.scene.scene import Scene

__all__ = ["MOST_PATCHES", "halved"]

MOST_PATCHES = 1 << 20


def halved(scene: Scene, patches: int) -> Scene:
    """The scene with so many patches: the largest is cut across its longest side, again and again.

    Halves take the place of their patch, so neighbours keep neighbouring numbers. Of equal patches the one with the
    smaller number comes first.

    Parameters
    ----------
    patches
        At least those of the scene, and at most `MOST_PATCHES`.

    Raises
    ------
    TypeError
        The number is no int.
    InputError
        It is out of range.
    """
    check_int("Patches", patches)
    if not len(scene) <= patches <= MOST_PATCHES:
        raise InputError(f"scene {scene.name!r}: Patches must be {len(scene)} to {MOST_PATCHES}, not {patches!r}")
    # The place of a half among those of its patch is a fraction of two to the power of its generation.
    parts = [(parent, 0.0, 1.0, corners) for parent, corners in enumerate(scene.vertices)]
    heap = [(-area, number) for number, area in enumerate(scene.areas.tolist())]
    heapq.heapify(heap)
    for _ in range(patches - len(scene)):
        _, number = heapq.heappop(heap)
        parent, place, width, corners = parts[number]
        first, second = _halves(corners)
        parts[number] = parent, place, width / 2, first
        parts.append((parent, place + width / 2, width / 2, second))
        for half in (number, len(parts) - 1):
            heapq.heappush(heap, (-_area(parts[half][3]), half))
    parts.sort(key=lambda part: part[:2])
    parent = np.array([part[0] for part in parts])
    return scene.with_parts(parent, np.stack([part[3] for part in parts]))


def _area(corners):
    return 0.5 * float(np.linalg.norm(np.cross(corners[2] - corners[0], corners[3] - corners[1])))


def _halves(corners):
    """Both halves, 4 x 3 each: quads from a quad, triangles from a triangle."""
    a, b, c, d = corners
    lengths = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    if (c == d).all():
        # The longest edge is cut, to the corner opposite.
        side = int(np.argmax((lengths[0], lengths[1], lengths[3])))
        a, b, c = np.roll(corners[:3], -side, axis=0)
        middle = (a + b) / 2
        return np.stack([a, middle, c, c]), np.stack([middle, b, c, c])
    if lengths[0] + lengths[2] >= lengths[1] + lengths[3]:
        low, high = (a + b) / 2, (d + c) / 2
        return np.stack([a, low, high, d]), np.stack([low, b, c, high])
    left, right = (a + d) / 2, (b + c) / 2
    return np.stack([a, b, right, left]), np.stack([left, right, c, d])
