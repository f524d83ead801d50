"""The frustum of a command that casts one."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, whole_number, whole_pair
from golden.base.finite_point import finite_point
from golden.cast.default_camera import default_camera
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene

__all__ = ["FrustumChoice"]


@dataclass(frozen=True, kw_only=True)
class FrustumChoice:
    """The requested frustum: a hemisphere at a point or on a patch, or a screen.

    Parameters
    ----------
    origin, normal
        Where the rays of a hemisphere start, and the direction of its middle.
    patch
        In place of both, the middle of this patch's front.
    rays
        Azimuths and polars of the hemisphere.
    screen
        Width and height of a screen through the scene's view, in place of a hemisphere.

    Raises
    ------
    InputError
        Not exactly one of the three kinds is chosen.
    """

    origin: tuple[float, ...] | None = None
    normal: tuple[float, ...] | None = None
    patch: int | None = None
    rays: tuple[int, int] = (256, 64)
    screen: tuple[int, int] | None = None

    def __post_init__(self):
        given = [name for name, value in (("--origin", self.origin), ("--patch", self.patch),
                                          ("--screen", self.screen)) if value is not None]
        if len(given) != 1:
            raise InputError("cast: one of --origin, --patch and --screen must be given, "
                             f"not {' and '.join(given) or 'none'}")
        if (self.origin is None) != (self.normal is None):
            raise InputError("cast: --origin and --normal must be given together")
        for name in ("rays", "screen"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, whole_pair(f"cast: {name.capitalize()}", value, parameter=name))
        for name in ("origin", "normal"):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, finite_point(f"cast: {name.capitalize()}", value, parameter=name))

    def record(self, scene: Scene, config: Config) -> tuple[FrustumRecord, PatchGeometry, np.ndarray | None]:
        """The frustum's record, the patches in its coordinates, and the weights of a hemisphere's rows.

        Raises
        ------
        InputError
            The scene has no such patch, or the frustum cannot be made.
        """
        if self.screen is not None:
            camera = default_camera(scene)
            geometry = PatchGeometry.of(scene, config.numbers, [camera.eye])
            screen = Screen(camera=camera, width=self.screen[0], height=self.screen[1])
            return screen_record(screen, geometry.coordinates), geometry, None
        origin, normal, source = self._base_point(scene)
        geometry, hemisphere = PatchGeometry.of(scene, config.numbers, [origin]), Hemisphere(*self.rays)
        record = hemisphere_record(hemisphere, geometry.coordinates, origin, normal, source=source)
        return record, geometry, hemisphere.polar_weights

    def facing_away(self, scene: Scene) -> str | None:
        """A warning if no patch lies in front of the hemisphere's base plane, but some lie behind it."""
        if self.screen is not None:
            return None
        origin, normal, _ = self._base_point(scene)
        height = (scene.vertices - origin) @ (np.asarray(normal) / np.linalg.norm(normal))
        least = 1e-9 * np.ptp(scene.vertices.reshape(-1, 3), axis=0).max()
        if height.max() > least or height.min() >= -least:
            return None
        if self.patch is None:
            return "no ray hits a patch: the hemisphere faces away from the scene; try the opposite --normal"
        return (f"no ray hits a patch: the front of patch {self.patch} faces away from the scene; reverse the "
                "patch's winding, or give --origin and --normal")

    def _base_point(self, scene):
        if self.patch is None:
            return self.origin, self.normal, -1
        patch = whole_number("cast: Patch", self.patch, 0, len(scene) - 1, parameter="patch")
        return scene.centres[patch], scene.normals[patch], int(scene.surface[patch])
