"""Origins and frusta that are hard to cast, and cuts of frusta into sectors."""

import numpy as np

from golden.cast.default_camera import default_camera
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Config, Numbers
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.camera import Camera
from golden.scene.scene import Scene

__all__ = ["CONFIG", "halves", "hard_records", "random_origin"]

CONFIG = Config()


def hard_records(scene: Scene, *, origins: int, rays: tuple[int, int], pixels: tuple[int, int],
                 seed: int, numbers: Numbers = CONFIG.numbers) -> tuple[PatchGeometry, list[FrustumRecord]]:
    """A hemisphere and a screen from each of some random origins, and the scene's own view, in these numbers."""
    random = np.random.default_rng(seed)
    starts = [random_origin(scene, random) for _ in range(origins)]
    own = scene.camera or default_camera(scene)
    geometry = PatchGeometry.of(scene, numbers, [*(origin for origin, _, _ in starts), own.eye])
    coordinates = geometry.coordinates
    cameras = [Camera(eye=tuple(origin), target=tuple(origin + normal), up=tuple(random.normal(size=3)),
                      fov=float(random.choice([20, 60, 100]))) for origin, normal, _ in starts]
    return geometry, [
        *(hemisphere_record(Hemisphere(*rays), coordinates, origin, normal, source=source)
          for origin, normal, source in starts),
        *(screen_record(Screen(camera=camera, width=pixels[0], height=pixels[1]), coordinates)
          for camera in [*cameras, own])]


def random_origin(scene, random):
    """Origin, normal and source surface: on a patch, at a vertex, next to an edge, or anywhere near the scene."""
    patch = int(random.integers(len(scene)))
    corners, kind = scene.vertices[patch], random.integers(4)
    normal = random.normal(size=3)
    if kind == 0:
        weights = random.dirichlet(np.ones(4))
        return weights @ corners, scene.normals[patch] * random.choice([-1, 1]), int(scene.surface[patch])
    if kind == 1:
        return corners[random.integers(4)], normal, -1
    if kind == 2:
        middle = random.random() * (corners[1] - corners[0]) + corners[0]
        return middle + random.normal(size=3) * scene.size * 10.0**random.uniform(-6, -2), normal, -1
    lower, upper = scene.bounds
    return random.uniform(lower - 0.1 * scene.size, upper + 0.1 * scene.size), normal, -1


def halves(record: FrustumRecord, parts: int) -> tuple[Sector, ...]:
    """The frustum cut ``parts`` times (a power of two) by halves, across the longer side first."""
    sectors = [Sector.whole(record)]
    while len(sectors) < parts:
        halves = []
        for sector in sectors:
            columns, rows = sector.end_column - sector.first_column, sector.end_row - sector.first_row
            if columns >= rows:
                middle = sector.first_column + columns // 2
                halves += [Sector(sector.first_column, middle, sector.first_row, sector.end_row),
                           Sector(middle, sector.end_column, sector.first_row, sector.end_row)]
            else:
                middle = sector.first_row + rows // 2
                halves += [Sector(sector.first_column, sector.end_column, sector.first_row, middle),
                           Sector(sector.first_column, sector.end_column, middle, sector.end_row)]
        sectors = halves
    return tuple(sectors)
