"""Frusta cast as single rays."""

from collections.abc import Callable

from golden.cast.rays import Hits

__all__ = ["FrustumHits", "RayFrusta"]

# Function from the numbers of frusta, the numbers of rays in them, and the `Rays` (one row each) to the hits.
FrustumHits = Callable[..., Hits]


class RayFrusta:
    """Base class of casters with ``nearest``, which makes them casters of frusta.

    A caster of frusta has the member below and the two methods; `golden.engine.cast.fixed_frusta.FixedFrusta` is the
    other kind.

    Members
    -------
    regular
        Whether a screen's rays must pass through the middles of the pixels' fields.
    """

    regular = False

    def hemispheres(self, hemisphere, points, frames, surfaces) -> FrustumHits:
        """Caster of the hemispheres at M points.

        Parameters
        ----------
        hemisphere
            The grid of rays.
        points, frames
            M x 3 origins, and M x 3 x 3 axes as `golden.cast.frame` gives them.
        surfaces
            M int: the surface of each point, which its rays never hit, or -1.
        """
        return self._each

    def screen(self, screen, side: int) -> FrustumHits:
        """Caster of the rays of a picture.

        Parameters
        ----------
        screen
            The picture's pixels.
        side
            Each pixel is ``side`` x ``side`` fields with a ray each. Rays are numbered as the pixels of a picture that
            many times finer.
        """
        return self._each

    def _each(self, frustum, number, rays):
        return self.nearest(rays)
