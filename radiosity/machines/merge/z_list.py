"""z-list: a volume renderer that sweeps scanlines, with the faces along each ray in a sorted list."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.merge.screen_split import ScreenSplit
from radiosity.machines.merge.screen_volume import ScreenVolume

__all__ = ["RegionWork", "composed", "render_regions", "transferred"]

_NONE = -1


class RegionWork(NamedTuple):
    """What P nodes have drawn.

    Parameters
    ----------
    picture
        H x W x 4 float64: red, green and blue before a black background, and opacity.
    spans
        P int64: runs of pixels of the own region, of all faces on all scanlines.
    pixels
        P int64: entries of the z-lists of all pixels.
    steps
        P int64: entries that others pass, for which z-lists stay sorted.
    """

    picture: np.ndarray
    spans: np.ndarray
    pixels: np.ndarray
    steps: np.ndarray


def render_regions(volume: ScreenVolume, split: ScreenSplit, *, is_sampled: bool = True) -> RegionWork:
    """Each node draws the pixels of its region with its own faces alone.

    A face covers the pixels whose centres are in it, so each ray meets it once. Depths are computed from the ends of a
    span rather than by increments from the region's border, by which the picture would depend on the split. Two
    consecutive entries of a z-list bound a cell that both faces have. The source requires an interior face among them;
    so a cell with two exterior faces has no sample there, and has one here.

    Parameters
    ----------
    volume
        On the screen.
    split
        The regions.
    is_sampled
        Whether cells are sampled; without, the work is counted alone and the picture is black.

    Source: Kurc 1997, section 6.3.
    """
    nodes = len(split.faces.start) - 1
    picture = np.zeros((volume.height, volume.width, 4))
    spans, pixels, steps = np.zeros((3, nodes), dtype=np.int64)
    extents = _extents(split.owner, nodes)
    for node in range(nodes):
        own = split.faces.face[split.faces.start[node]:split.faces.start[node + 1]]
        if len(own) and extents[node, 0] <= extents[node, 2]:
            spans[node], pixels[node], steps[node] = _draw(
                volume.points, volume.values, volume.faces, volume.sides, own, split.owner, node, extents[node],
                is_sampled, picture)
    return RegionWork(picture, spans, pixels, steps)


@compiled
def _extents(owner, nodes):
    """First x, first y, last x and last y of each region."""
    found = np.empty((nodes, 4), dtype=np.int64)
    found[:, :2], found[:, 2:] = 1 << 30, -1
    for y in range(owner.shape[0]):
        for x in range(owner.shape[1]):
            one = found[owner[y, x]]
            one[0], one[1] = min(one[0], x), min(one[1], y)
            one[2], one[3] = max(one[2], x), max(one[3], y)
    return found


@compiled
def transferred(value):
    """Red, green, blue and opacity of a sample: blue to red, and the more opaque the larger the value is."""
    return value, 4 * value * (1 - value), 1 - value, 0.02 + 0.1 * value * value


@compiled
def composed(ahead, value):
    """Put a sample behind what is ahead of it, from front to back: C O and O.

    Source: Kurc 1997, Eq. 5.2.
    """
    red, green, blue, opacity = transferred(value)
    weight = opacity * (1 - ahead[3])
    ahead[0] += red * weight
    ahead[1] += green * weight
    ahead[2] += blue * weight
    ahead[3] += weight


@compiled
def _crossings(points, faces, face, y, ends):
    """The ends of the span of a face on a scanline: x and z of both; whether it has one.

    An edge is walked from its lower point number, so that both faces of an edge cross at one x. It has its upper end,
    and not its lower one.
    """
    met = 0
    for edge in range(3):
        a, b = faces[face, 0 if edge < 2 else 1], faces[face, 1 if edge == 0 else 2]
        if (points[a, 1] <= y) == (points[b, 1] <= y):
            continue
        share = (y - points[a, 1]) / (points[b, 1] - points[a, 1])
        ends[met, 0] = points[a, 0] + share * (points[b, 0] - points[a, 0])
        ends[met, 1] = points[a, 2] + share * (points[b, 2] - points[a, 2])
        met += 1
    if met == 2 and ends[0, 0] > ends[1, 0]:
        for field in range(2):
            ends[0, field], ends[1, field] = ends[1, field], ends[0, field]
    return met == 2


@compiled
def _sample(points, values, faces, front, back, x, y, z):
    """The value of a cell at a point: of the corners of both its faces, weighted by the inverses of their distances."""
    above, below = 0.0, 0.0
    for corner in range(4):
        at = faces[front, min(corner, 2)]
        if corner == 3:
            for other in range(3):
                if (faces[back, other] != faces[front, 0] and faces[back, other] != faces[front, 1]
                        and faces[back, other] != faces[front, 2]):
                    at = faces[back, other]
        distance = np.sqrt((points[at, 0] - x)**2 + (points[at, 1] - y)**2 + (points[at, 2] - z)**2)
        if distance == 0:
            return values[at]
        above += values[at] / distance
        below += 1 / distance
    return above / below


@compiled
def _draw(points, values, faces, sides, own, owner, node, extent, is_sampled, picture):
    """Draw a region; its spans, pixels and steps."""
    left, top, right, bottom = extent
    bucket, after = np.full(bottom - top + 1, _NONE), np.full(len(own), _NONE)
    last_row = np.empty(len(own), dtype=np.int64)
    for at in range(len(own) - 1, -1, -1):
        ys = points[faces[own[at]], 1]
        first = max(int(np.ceil(ys.min())), top)
        last_row[at] = min(int(np.ceil(ys.max())) - 1, bottom)
        # A centre on the lowest point is not in the face, one on the highest is.
        if first <= bottom and last_row[at] >= first:
            after[at], bucket[first - top] = bucket[first - top], at
    active, ends = np.empty(len(own), dtype=np.int64), np.empty((2, 2))
    x_bucket, x_after = np.full(right - left + 1, _NONE), np.empty(len(own), dtype=np.int64)
    span_end, span = np.empty(len(own), dtype=np.int64), np.empty((len(own), 3))
    listed, depth = np.empty(len(own), dtype=np.int64), np.empty(len(own))
    count, spans, pixels, steps = 0, 0, 0, 0
    for y in range(top, bottom + 1):
        at = bucket[y - top]
        while at != _NONE:
            active[count] = at
            count += 1
            at = after[at]
        kept = 0
        for number in range(count):
            at = active[number]
            if last_row[at] > y:
                active[kept] = at
                kept += 1
            if not _crossings(points, faces, own[at], y, ends):
                continue
            first = max(int(np.ceil(ends[0, 0])), left)
            span_end[at] = min(int(np.ceil(ends[1, 0])) - 1, right)
            if first > span_end[at]:
                continue
            span[at, 0], span[at, 1] = ends[0, 0], ends[0, 1]
            span[at, 2] = (ends[1, 1] - ends[0, 1]) / (ends[1, 0] - ends[0, 0])
            x_after[at], x_bucket[first - left] = x_bucket[first - left], at
        count = kept
        length = 0
        for x in range(left, right + 1):
            at = x_bucket[x - left]
            x_bucket[x - left] = _NONE
            is_own = owner[y, x] == node
            is_begun = is_own and (x == left or owner[y, x - 1] != node)
            # Ended spans leave; the others keep their order, which is nearly that of this pixel.
            kept = 0
            for number in range(length):
                if span_end[listed[number]] >= x:
                    listed[kept] = listed[number]
                    kept += 1
            length = kept
            spans += length if is_begun else 0
            while at != _NONE:
                listed[length] = at
                length += 1
                spans += is_own
                at = x_after[at]
            if not is_own:
                continue
            pixels += length
            for number in range(length):
                at = listed[number]
                z, hole = span[at, 1] + (x - span[at, 0]) * span[at, 2], number
                while hole > 0 and (depth[hole - 1] > z or (depth[hole - 1] == z and listed[hole - 1] > at)):
                    depth[hole], listed[hole] = depth[hole - 1], listed[hole - 1]
                    hole -= 1
                    steps += 1
                depth[hole], listed[hole] = z, at
            for number in range(length - 1 if is_sampled else 0):
                front, back = own[listed[number]], own[listed[number + 1]]
                is_cell = False
                for one in range(2):
                    for other in range(2):
                        is_cell |= sides[front, one] != _NONE and sides[front, one] == sides[back, other]
                if is_cell:
                    composed(picture[y, x], _sample(points, values, faces, front, back, x, y,
                                                    (depth[number] + depth[number + 1]) / 2))
    return spans, pixels, steps
