"""Node boxes: the pixels and the box of space of each node, and how boxes grow into their neighbours."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from radiosity.machines.torus.torus_scene import TorusScene

__all__ = ["GROWTHS", "NodeBoxes", "front_face", "node_boxes"]

GROWTHS = ("axis", "volume")
"""What a growth is a share of: the length of an axis, or the volume."""

# Space before and behind the objects, in depths of the scene.
_DEPTH_MARGIN = 0.01


@dataclass(frozen=True, kw_only=True, eq=False)
class NodeBoxes:
    """Pixels and boxes of k x k nodes. Node ``row * k + column`` counts from the lower left; so do rows of pixels.

    Parameters
    ----------
    rows, columns
        k + 1 int64: the first row and the first column of pixels of each row and column of nodes, and the ends.
    inner
        P x 2 x 3: least and largest coordinates of each node's box. Boxes share faces, and have the whole depth.
    grown
        The same, grown.
    front
        z at which primary rays enter their node's box.
    """

    rows: np.ndarray
    columns: np.ndarray
    inner: np.ndarray
    grown: np.ndarray
    front: float

    @property
    def side(self) -> int:
        """K."""
        return len(self.rows) - 1


def front_face(scene: TorusScene, aspect: float) -> float:
    """Z of the front of object space or, where the eye is within it, of the nearest object in view.

    The source has its eyes before the scene. Before the front no primary ray meets an object either way.

    Parameters
    ----------
    scene
        The objects.
    aspect
        Width of the picture over its height.
    """
    low = scene.bounds[:, 0, 2].min()
    if low > 0:
        return float(low)
    nearest, slopes = np.inf, scene.slope * np.array([aspect, 1.0])
    for corners, count in zip(scene.corners, scene.counts, strict=True):
        if count == 0:
            nearest = min(nearest, max(corners[0, 2] - corners[1, 0], 0.0))
            continue
        polygon = corners[:count]
        for axis in range(2):
            for sign in (1, -1):
                polygon = _clipped(polygon, slopes[axis] * polygon[:, 2] - sign * polygon[:, axis])
        if len(polygon):
            nearest = min(nearest, polygon[:, 2].min())
    # An object at the eye leaves no space before it; nothing in view leaves all.
    return float(nearest) if 0 < nearest < np.inf else float(np.abs(scene.bounds[:, :, 2]).max() * 1e-6 + 1e-12)


def _clipped(polygon, height):
    """The part of a convex polygon where the height of its corners is not negative."""
    kept = []
    for at in range(len(polygon)):
        after = (at + 1) % len(polygon)
        if height[at] >= 0:
            kept.append(polygon[at])
        if (height[at] >= 0) != (height[after] >= 0):
            kept.append(polygon[at] + (polygon[after] - polygon[at]) * height[at] / (height[at] - height[after]))
    return np.array(kept).reshape(-1, 3)


def node_boxes(scene: TorusScene, *, side: int, size: tuple[int, int], growth: float = 0.02,
               growth_by: str = "axis") -> NodeBoxes:
    """Divide pixels equally, and space along the rays through the corners of the pixels of each node.

    Space beside the picture belongs to the outer nodes. A box grows on both sides of both axes, by its own size, but
    not beyond the neighbour on that side. The growth of a volume is that of a box whose depth, which is not cut, stays.

    Parameters
    ----------
    scene
        The objects.
    side
        k.
    size
        Rows and columns of pixels.
    growth
        Share by which a box grows, both sides together; at least 0.
    growth_by
        A name of `GROWTHS`. The source defines none.

    Raises
    ------
    InputError
        There are more rows of nodes than pixels, the growth is negative, or the name is none.

    Source: Pearce 1987, chapter 3, and chapter 5 for growth.
    """
    if growth_by not in GROWTHS:
        raise InputError(f"torus: Growth must be by {' or '.join(GROWTHS)}, not {growth_by!r}", parameter="growth")
    if not 0 <= growth <= 100:
        raise InputError(f"torus: Growth must be 0 to 100 times the box, not {growth!r}", parameter="growth")
    if side > min(size):
        raise InputError(f"torus: Pixels must be at least {side} in a row and in a column, not {min(size)}",
                         parameter="pixels")
    rows, columns = ((np.arange(side + 1) * count) // side for count in size)
    aspect = size[1] / size[0]
    front, bounds = front_face(scene, aspect), scene.bounds
    low, high = bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)
    margin = _DEPTH_MARGIN * max(high[2] - low[2], 1e-6 * np.abs(bounds).max())
    cuts = []
    for axis, (edges, count, slope) in enumerate(((columns, size[1], aspect), (rows, size[0], 1.0))):
        cut = (2 * edges / count - 1) * scene.slope * slope * front
        cut[0], cut[-1] = min(cut[0], low[axis]), max(cut[-1], high[axis])
        cuts.append(cut)
    share = growth if growth_by == "axis" else np.sqrt(1 + growth) - 1
    grown = [_grown(cut, share) for cut in cuts]

    def boxes(spans):
        box = np.empty((side, side, 2, 3))
        box[:, :, :, 0], box[:, :, :, 1] = spans[0][None], spans[1][:, None]
        box[:, :, :, 2] = low[2] - margin, max(high[2], front) + margin
        return box.reshape(-1, 2, 3)

    return NodeBoxes(rows=rows, columns=columns, inner=boxes([np.stack([cut[:-1], cut[1:]], 1) for cut in cuts]),
                     grown=boxes(grown), front=front)


def _grown(cut, share):
    """Spans between cuts, grown by a share, but not beyond the next cut but one."""
    half = np.diff(cut) * share / 2
    low, high = cut[:-1] - half, cut[1:] + half
    low[1:] = np.maximum(low[1:], cut[:-2])
    high[:-1] = np.minimum(high[:-1], cut[2:])
    return np.stack([low, high], axis=1)
