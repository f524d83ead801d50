"""Facets whose view factors are known: closed forms of the literature, and relations that hold under occlusion."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from benchmarks.closed_forms import b_4, c_11, c_14, c_41
from golden.light.factors.view_factors import ViewFactors
from golden.scene.builtin.shapes import FACES, box, cap, loft

__all__ = ["BARRIER", "HIDDEN", "OPEN", "Case", "box_in_box", "plate_between_plates", "visible_factor"]

# Half the length of a street, in its widths: what an endless street has beyond is below 1e-6 of a facet's radiation.
_ENDLESS = 500.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """Facets and some of their view factors.

    Parameters
    ----------
    name
        What they are.
    facets
        N x 4 x 3, fronts towards each other.
    known
        Triples of the facets at which radiation starts, those at which it arrives, and the share that arrives. None as
        the second one is the sky.
    """

    name: str
    facets: np.ndarray
    known: list[tuple[np.ndarray, np.ndarray | None, float]]

    def largest_error(self, F, sky: np.ndarray | None, area: np.ndarray) -> float:
        """Largest difference of an N x N matrix and N sky view factors from what is known; None as sky skips those."""
        found = []
        for starts, ends, truth in self.known:
            if ends is None and sky is None:
                continue
            seen = sky[starts] if ends is None else F[starts][:, ends].sum(axis=1)
            found.append(abs(area[starts] @ seen / area[starts].sum() - truth))
        return float(max(found))

    def deviations(self, found: ViewFactors) -> np.ndarray:
        """Of each known factor of two facets how many standard errors its measurement, before the projection, is off.

        Exact ones are left out, and of a pair the second direction: both are one measurement.
        """
        deviations = {}
        for starts, ends, truth in self.known:
            if ends is None or len(starts) * len(ends) > 1:
                continue
            pair = starts[0], ends[0]
            if found.error[pair]:
                deviations.setdefault(frozenset(pair), (found.unprojected[pair] - truth) / found.error[pair])
        return np.array(list(deviations.values()))


def _inside(lower, upper, *faces):
    """Faces of a box, fronts inwards."""
    return box(lower, upper)[[FACES.index(face) for face in faces or FACES], ::-1]


def _opposed(x, y):
    return Case(name=f"opposed rectangles {x:g} x {y:g} at distance 1, C-11",
                facets=_inside((0, 0, 0), (x, y, 1), "-z", "+z"),
                known=[([0], [1], c_11(x, y)), ([1], [0], c_11(x, y))])


def _adjoining(w, h):
    return Case(name=f"rectangles 1 x {w:g} and 1 x {h:g} at a common edge, C-14",
                facets=_inside((0, 0, 0), (w, 1, h), "-z", "-x"),
                known=[([0], [1], c_14(w, h)), ([1], [0], c_14(h, w))])


def _ring(radius, height, *, sides, centre=0.0):
    """A regular polygon with a circle's area, counter-clockwise as seen from above."""
    angle = 2 * np.pi * np.arange(sides) / sides
    corner = radius * np.sqrt(2 * np.pi / sides / np.sin(2 * np.pi / sides))
    return np.stack([centre + corner * np.cos(angle), centre + corner * np.sin(angle), np.full(sides, height)], axis=1)


def _discs(r1, r2):
    lower, upper = cap(_ring(r1, 0, sides=128)), cap(_ring(r2, 1, sides=128)[::-1])
    first, second = np.arange(len(lower)), len(lower) + np.arange(len(upper))
    return Case(name=f"coaxial discs of radius {r1:g} and {r2:g} at distance 1, C-41, as polygons",
                facets=np.concatenate([lower, upper]),
                known=[(first, second, c_41(r1, r2)), (second, first, c_41(r2, r1))])


def _bends():
    beside = c_11(2, 1) - c_11(1, 1)
    across = c_11(2, 2) - c_11(1, 1) - 2 * beside
    squares = [((0, 0), (1, 1)), ((1, 0), (2, 1)), ((0, 1), (1, 2))]
    facets = np.concatenate([_inside((*low, 0), (*high, 1), face) for face in ("-z", "+z") for low, high in squares])
    return Case(name="opposed L shapes of three unit squares, C-11", facets=facets,
                known=[([0, 1, 2], [3, 4, 5], (3 * c_11(1, 1) + 4 * beside + 2 * across) / 3),
                       ([0], [4], beside), ([1], [5], across)])


def _cube():
    known = [([one], [other], c_11(1, 1) if one // 2 == other // 2 else c_14(1, 1))
             for one in range(6) for other in range(6) if one != other]
    return Case(name="cube, C-11 and C-14", facets=_inside((0, 0, 0), (1, 1, 1)), known=known)


def plate_between_plates(width: float = 0.5) -> Case:
    """Two unit squares at distance 1, and a plate over the part 0..``width`` of the lower one, halfway up."""
    facets = np.concatenate([_inside((0, 0, 0), (1, 1, 1), "-z", "+z"), _inside((0, 0, 0.5), (width, 1, 1), "-z")])
    truth = visible_factor(width)
    return Case(name=f"plate of width {width:g} between unit squares", facets=facets,
                known=[([0], [1], truth), ([1], [0], truth)])


def visible_factor(width: float = 0.5) -> float:
    """Of `plate_between_plates` from the lower square to the upper one.

    C-11 less the factor to the plate's shadow, which is a rectangle from every point.
    """
    knots, gauss = np.polynomial.legendre.leggauss(24)
    share, y = gauss / 2, (knots + 1) / 2
    # The shadow's borders cross the ceiling's along these lines, between which the factor is smooth.
    cuts = np.unique(np.clip([0, 2 * width - 1, width, 2 * width, 1], 0, 1))
    total = 0.0
    for low, high in pairwise(cuts):
        x = (low + (high - low) * y)[:, None]
        end = np.clip(2 * width - x, 0, 1)
        # B-4 is odd in both sides of its rectangle.
        shadow = b_4(end - x, 1 - y) - b_4(end - x, -y) - b_4(-x, 1 - y) + b_4(-x, -y)
        total += (high - low) * (share @ shadow @ share)
    return c_11(1, 1) - total


def _canyon(barrier):
    """A street as wide as its walls are high, maybe with a barrier along its middle; Hottel's crossed strings."""
    long = _ENDLESS
    street = [_inside((left, low, 0), (left + 0.5, high, 1), "-z") for left in (0, 0.5)
              for low, high in ((-long, -0.5), (-0.5, 0.5), (0.5, long))]
    facets = np.concatenate([*street, _inside((0, -long, 0), (1, long, 1), "-x", "+x")])
    # The string from the near corner of the street to the top of the far wall passes above the barrier.
    far = np.hypot(0.5, barrier) + np.hypot(0.5, 1 - barrier) - np.sqrt(2)
    known = [([1], [7], far), ([4], [6], far)]
    if not barrier:
        sky = 1 - far - (1.5 - np.hypot(0.5, 1))
        return Case(name="street canyon, crossed strings", facets=facets,
                    known=[*known, ([1], None, sky), ([4], None, sky)])
    faces = _inside((0, -long, 0), (0.5, long, barrier), "+x"), _inside((0.5, -long, 0), (1, long, barrier), "-x")
    return Case(name=f"street canyon with a barrier of height {barrier:g}, crossed strings",
                facets=np.concatenate([facets, *faces]), known=known)


def box_in_box(side: float, cuts: int = 1) -> Case:
    """A cube in the middle of a unit cube, each face cut into ``cuts`` x ``cuts`` facets.

    Nothing convex sees itself, so all that an inner face sees is the outer cube. By symmetry each outer face sees of
    the inner cube as much as the others.
    """
    low = (1 - side) / 2
    faces = np.concatenate([box((low,) * 3, (low + side,) * 3), _inside((0, 0, 0), (1, 1, 1))])
    cells = np.stack(np.mgrid[:cuts, :cuts], axis=-1).reshape(-1, 1, 2) + np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    u, v = np.moveaxis(cells / cuts, -1, 0)[..., None]
    origin, along, up = (faces[:, k, None, None] - faces[:, 0, None, None] * (k > 0) for k in (0, 1, 3))
    facets = (origin + u * along + v * up).reshape(-1, 4, 3)
    inner, outer = np.arange(12 * cuts**2).reshape(2, 6, -1)
    return Case(name=f"cube of side {side:g} in a unit cube", facets=facets,
                known=[*((face, inner.ravel(), side**2) for face in outer),
                       *((face, outer.ravel(), 1 - side**2) for face in outer),
                       *((face, outer.ravel(), 1.0) for face in inner)])


def _cylinder_in_box(radius):
    """A prism for a cylinder, of half the box's height."""
    low, high = (_ring(radius, height, sides=24, centre=0.5) for height in (0.25, 0.75))
    prism = np.concatenate([loft([low, high]), cap(low[::-1]), cap(high)])
    inner, outer = np.arange(len(prism)), len(prism) + np.arange(6)
    area = 2 * np.pi * radius**2 + 0.5 * np.linalg.norm(low - np.roll(low, 1, axis=0), axis=1).sum()
    return Case(name=f"cylinder of radius {radius:g} in a unit cube, as a prism of 24 sides",
                facets=np.concatenate([prism, _inside((0, 0, 0), (1, 1, 1))]),
                known=[(outer, inner, area / 6), (outer, outer, 1 - area / 6), (inner, outer, 1.0)])


OPEN: tuple[Callable[[], Case], ...] = (
    *(partial(_opposed, x, y) for x, y in ((1, 1), (2, 2), (0.3, 5), (10, 10))),
    *(partial(_adjoining, w, h) for w, h in ((1, 1), (0.2, 3), (5, 0.1))),
    partial(_discs, 1, 1), partial(_discs, 0.5, 2), _bends, _cube, partial(_canyon, 0))
BARRIER = partial(_canyon, 0.25)
HIDDEN: tuple[Callable[[], Case], ...] = (
    *(partial(plate_between_plates, width) for width in (0.3, 0.5, 0.8)), BARRIER,
    partial(box_in_box, 0.3), partial(box_in_box, 0.6), partial(_cylinder_in_box, 0.3))
