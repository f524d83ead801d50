"""Drawn patches of unequal areas: trapezoids, kites and triangles, one- and two-sided."""

import numpy as np
from hypothesis import strategies as st

from golden.scene.scene import Scene
from tb.golden.light.scenes import BLACK, scene_of

__all__ = ["unequal_scenes"]

_LENGTHS = st.sampled_from((0.25, 0.5, 1.0, 2.0, 3.0))


@st.composite
def _patches(draw, height):
    """A patch in a level plane: its diagonals cross in the origin, and their four parts have lengths of their own."""
    east, north, west, south = (draw(_LENGTHS) for _ in range(4))
    corners = [(east, 0), (0, north), (-west, 0), (0, -south)]
    # Without its last corner a triangle, of which a point is repeated.
    corners = [*corners[:3], corners[2]] if draw(st.booleans()) else corners
    return np.array([(x, y, height) for x, y in corners], dtype=float)


@st.composite
def unequal_scenes(draw) -> Scene:
    """Draws a scene of one to four patches, one above the other."""
    return scene_of(*((draw(_patches(float(number))), BLACK, {"two_sided": draw(st.booleans())})
                      for number in range(draw(st.integers(1, 4)))))
