"""The pixels of a picture: their primary rays, and which of them are cast again."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.base.progress_bar import progress_bar
from golden.base.spread import Spread, spans
from golden.cast.screen import Screen
from golden.light.sampling import mix, pixel_ranks, uniform

__all__ = ["MOST", "PixelSums", "Pixels"]

MOST = 1024
"""Most primary rays of a pixel that are cast at once."""
# Errors are relative to a pixel's radiance plus this share of the picture's mean.
DARK = 0.1


@dataclass(frozen=True, kw_only=True, eq=False)
class PixelSums:
    """Of P pixels.

    Parameters
    ----------
    sums
        6 x P: sums over their primary rays, with the rows of the shader's ``trace``.
    rays
        P int64: how many those are.
    error
        P: estimates of their relative standard errors, or None.
    """

    sums: np.ndarray
    rays: np.ndarray
    error: np.ndarray | None


class Pixels:
    """Primary rays of whole pixels, so that their sums do not depend on the batch, and what they see. Which shadow rays
    are enough for a frustum, and so how they are rounded, does.

    Each round casts some pixels, in fields half as wide as those of the round before; with a regular caster, whose rays
    pass through the middles of the same fields, four times as often. Halves of a pixel's rays that alternate like the
    squares of a chessboard estimate its error: half of their difference, or the root of the mean square over 3 x 3
    pixels if that is more.

    Parameters
    ----------
    caster, shader
        Caster of a screen, see `golden.cast.ray_frusta.RayFrusta`, and what the light along its rays is.
    screen, settings
        The pixels, and `golden.render.two_pass.RenderSettings`.
    regular
        See `golden.cast.ray_frusta.RayFrusta`.
    """

    def __init__(self, caster, shader, screen: Screen, settings, regular: bool):
        self._caster, self._shader, self._screen, self._regular = caster, shader, screen, regular
        self._side, self._seed, self._noise = settings.side, settings.seed, settings.noise
        self._round, self._some = 0, np.arange(len(screen))

    def cast(self, spread: Spread, batch: int, progress: bool) -> PixelSums:
        """Cast all pixels, and those again whose errors exceed the noise that the settings request.

        ``spread`` casts spans of about ``batch`` rays; ``progress`` shows a bar after two seconds.
        """
        count = len(self._screen)
        sums, half, rays, error = np.zeros((6, count)), np.zeros((3, count)), np.zeros(count, dtype=np.int64), None
        while len(self._some):
            fields = self._across**2
            with progress_bar(total=len(self._some) * fields, desc="image", unit="ray", unit_scale=True, delay=2,
                              disable=not progress) as bar:
                for (first, last), part in spread(self.totals, spans(len(self._some), max(1, batch // fields))):
                    pixels = self._some[first:last]
                    sums[:, pixels] += part[:6]
                    half[:, pixels] = part[6:]
                    bar.update((last - first) * fields)
            rays[self._some] += fields
            if self._noise is None:
                break
            error = self._error(sums[:3] / rays, half)
            if 4 * fields > MOST:
                break
            self._some, self._round = np.flatnonzero(error > self._noise), self._round + 1
        return PixelSums(sums=sums, rays=rays, error=error)

    def totals(self, first: int, last: int) -> np.ndarray:
        """9 x P of the round's pixels ``first`` to ``last`` - 1: sums as `PixelSums` has them, errors of radiance."""
        pixels, across, count = self._some[first:last], self._side if self._regular else self._across, self._across**2
        own, sample = np.divmod(np.arange(len(pixels) * count), count)
        row, column = np.divmod(pixels[own], self._screen.width)
        again, number = np.divmod(sample, across**2)
        field = np.stack([number % across, number // across], axis=1)
        within = 0.5 if self._regular else self._within(pixels)
        rays = self._screen.rays(pixels[own], (field + within) / across - 0.5)
        fields = (row * across + field[:, 1]) * (self._side * self._screen.width) + column * across + field[:, 0]
        hits = self._cast(np.zeros(len(fields), dtype=np.int64), fields, rays)
        half = (again if self._regular and self._round else field.sum(axis=1)) % 2
        # Each half has light samples that follow each other: they spread together.
        order = half[:count].argsort(kind="stable").argsort()
        rank = count * pixel_ranks(column, row) + order[sample]
        traced = self._shader.trace(rays, hits, mix(self._seed, 2, self._round), rank,
                                    fields if self._regular else None)
        share = np.bincount(half[:count], minlength=2)
        weight = np.where(half, 0.5, -0.5) / np.maximum(share, 1)[half]
        return np.stack([np.bincount(own, values, len(pixels)) for values in (*traced, *(traced[:3] * weight))])

    @property
    def _across(self):
        """Fields along the sides of the round's pixels."""
        return self._side << self._round

    @cached_property
    def _cast(self):
        """Kept over the rounds: a regular caster casts once."""
        return self._caster.screen(self._screen, self._side)

    def _within(self, pixels):
        """Random points in the fields of pixels: no two of a pixel are in the same one of as many columns or rows."""
        side, keys = self._across, mix(self._seed, 1, self._round, pixels)
        lines = mix(keys[:, None, None], np.arange(2)[:, None], np.arange(side)).argsort(axis=2)
        across = np.broadcast_to(lines[:, 0, :, None], (len(pixels), side, side))
        down = np.broadcast_to(lines[:, 1, None, :], across.shape)
        line = np.stack([across, down], axis=3).reshape(-1, 2)
        draws = mix(np.repeat(keys, side**2), 2, np.tile(np.arange(side**2), len(pixels)))
        return (line + np.stack([uniform(draws, axis) for axis in range(2)], axis=1)) / side

    def _error(self, radiance, half):
        """P relative standard errors, of the last round alone."""
        from scipy.ndimage import uniform_filter  # slow

        value = radiance.mean(axis=0)
        square = (half**2).mean(axis=0) / np.maximum(value + DARK * value.mean(), 1e-300) ** 2
        around = uniform_filter(square.reshape(self._screen.height, self._screen.width), 3, mode="nearest")
        return np.sqrt(np.maximum(square, around.ravel()))
