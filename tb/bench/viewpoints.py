"""Where the benches cast from."""

import numpy as np

from golden.config import Numbers
from golden.frustum import FrustumRecord, Hemisphere, Screen, hemisphere_record, screen_record
from golden.scene.camera import Camera
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene
from golden.scene.view import default_camera
from tb.golden.cast.frusta import CONFIG, random_origin

__all__ = ["hard_records"]


def hard_records(scene: Scene, *, origins: int, rays: tuple[int, int], pixels: tuple[int, int],
                 seed: int, numbers: Numbers = CONFIG.numbers) -> tuple[PatchGeometry, list[FrustumRecord]]:
    """In these numbers a hemisphere and a screen from each of some origins (see `random_origin`), and the own view."""
    random = np.random.default_rng(seed)
    places = [random_origin(scene, random) for _ in range(origins)]
    own = scene.camera or default_camera(scene)
    geometry = PatchGeometry.of(scene, numbers, [*(origin for origin, _, _ in places), own.eye])
    coordinates = geometry.coordinates
    cameras = [Camera(eye=tuple(origin), target=tuple(origin + normal), up=tuple(random.normal(size=3)),
                      fov=float(random.choice([20, 60, 100]))) for origin, normal, _ in places]
    return geometry, [
        *(hemisphere_record(Hemisphere(*rays), coordinates, origin, normal, source=source)
          for origin, normal, source in places),
        *(screen_record(Screen(camera=camera, width=pixels[0], height=pixels[1]), coordinates)
          for camera in [*cameras, own])]
