"""Pictures of a radiosity solution while it is sought."""

from collections.abc import Callable
from copy import copy
from functools import cached_property
from pathlib import Path

import numpy as np

from golden.base.errors import InputError, is_whole
from golden.base.output import check_outputs, whole_file
from golden.cast.casters import CastsRays
from golden.cast.screen import Screen
from golden.light.image import write_png
from golden.light.pieces import Pieces
from golden.light.solvers.iteration import State
from golden.light.tone import tone_map
from golden.scene.scene import Scene

__all__ = ["Preview"]


class Preview:
    """Draws what the pieces of elements emit and reflect, from the ambient estimate on; mirrors look diffuse.

    One ray through the middle of each pixel finds its piece, once.

    Parameters
    ----------
    path
        The picture (.png), replaced atomically at every ``steps``-th step from the first one on.
    steps
        At least 1.

    Raises
    ------
    InputError
        No file can be made there, or a value is out of range.
    """

    _scene: Scene
    _screen: Screen
    _caster: CastsRays
    _radiosity: np.ndarray

    def __init__(self, path: str | Path, *, steps: int = 8):
        check_outputs(Path(path), suffixes=(".png",))
        if not is_whole(steps) or steps < 1:
            raise InputError(f"preview: Steps must be at least 1, not {steps!r}", parameter="preview_steps")
        self.path, self._steps = Path(path), steps

    def of(self, scene: Scene, screen: Screen, caster: CastsRays) -> "Preview":
        """That of a picture of a scene, with a caster of rays; this one stays as it is, for other pictures."""
        made = copy(self)
        made._scene, made._screen, made._caster = scene, screen, caster
        return made

    def watch(self, pieces: Pieces) -> Callable[[State], None]:
        """Takes the states of a system of pieces, and draws some of them."""
        self._pieces, step = pieces, 0

        def see(state):
            nonlocal step
            if step % self._steps == 0:
                self._radiosity = state.radiosity + state.ambient
                self._draw()
            step += 1
        return see

    def _draw(self):
        piece, light = self._seen
        image = light + np.where(piece[:, None] >= 0, self._radiosity[piece], 0)
        with whole_file(self.path) as part:
            write_png(part, tone_map(image.reshape(self._screen.height, self._screen.width, 3)))

    @cached_property
    def _seen(self):
        """Of each pixel its piece, or -1, and what it shows without the pieces' light."""
        rays = self._screen.rays()
        hits = self._caster.nearest(rays)
        piece = self._pieces.seen(rays.direction, hits)
        emission = self._scene.channels("emission")[hits.patch]
        return piece, np.where(piece[:, None] >= 0, emission, 0)
