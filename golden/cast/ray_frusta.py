"""Frusta as so many single rays."""

from collections.abc import Callable

from golden.cast.rays import Hits

__all__ = ["FrustumHits", "RayFrusta"]

# Gives the hits of rays (one row each) from the numbers of their frusta, their numbers therein, and the `Rays`.
FrustumHits = Callable[..., Hits]


class RayFrusta:
    """What makes a caster of any rays a caster of frusta too: a base class for casters with ``nearest``.

    A caster of frusta has the three members below; `golden.cast.fixed_frusta.FixedFrusta` is the other kind.

    Members
    -------
    regular
        Whether a screen's rays must go through the middles of the pixels' fields.
    """

    regular = False

    def hemispheres(self, hemisphere, points, frames, surfaces) -> FrustumHits:
        """What casts the hemispheres at M points.

        Parameters
        ----------
        hemisphere
            The grid of rays.
        points, frames
            M x 3 origins, and M x 3 x 3 axes as `golden.frustum.frame` gives them.
        surfaces
            M int: the surface that each point lies on, which its rays never hit, or -1.
        """
        return self._each

    def screen(self, screen, side: int) -> FrustumHits:
        """What casts the rays of an image.

        Parameters
        ----------
        screen
            The image's pixels.
        side
            Each is ``side`` x ``side`` fields with a ray of their own. Rays are numbered as the pixels of an image so
            many times finer.
        """
        return self._each

    def _each(self, frustum, number, rays):
        return self.nearest(rays)
