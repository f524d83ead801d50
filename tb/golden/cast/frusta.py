"""Random small frusta that are hard to cast: soups of patches, origins on, beside and between them."""

from dataclasses import dataclass

import numpy as np

from benchmarks.viewpoints import CONFIG, halves, random_origin
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling
from golden.engine.frustum.record import FrustumRecord, hemisphere_record, screen_record
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from tb.golden.soups import soup

__all__ = ["CELLS", "CONFIG", "RandomFrustum", "halves", "random_frustum", "random_origin", "room", "speckled_frustum"]

# Cells along each side of the room of the specks, whose lower corner is (0, 0, 0) and whose cells have the side 1.
CELLS = 16


@dataclass(frozen=True, eq=False)
class RandomFrustum:
    """A frustum and the scene that it is cast into."""

    seed: int
    geometry: PatchGeometry
    record: FrustumRecord
    cell: float

    def shelling(self, *, by_code=False, config=CONFIG, **arguments):
        """Hits and counts."""
        return Shelling(self.geometry, config, cell=self.cell, by_code=by_code).cast(self.record, **arguments)

    def naive(self):
        """Hits."""
        return NaiveFixed(self.geometry, CONFIG).cast(self.record)

    def differing(self, **arguments) -> int:
        """Number of rays on which shelling and brute force in fixed point differ."""
        return len(self.shelling(**arguments)[0].differences(self.naive()))


def random_frustum(seed: int) -> RandomFrustum:
    """A soup, an origin, a hemisphere (three of four) or a screen, and a cell size."""
    random = np.random.default_rng(seed)
    scene = soup(seed, count=int(random.choice([12, 40, 120])))
    origin, normal, source = random_origin(scene, random)
    cell = float(random.choice([0.5, 0.25, 0.125, 0.0625, 0.04]))
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [origin])
    if seed % 4:
        azimuths, polars = ((16, 4), (32, 8), (64, 16))[random.integers(3)]
        record = hemisphere_record(Hemisphere(azimuths, polars), geometry.coordinates, origin, normal, source=source)
    else:
        camera = Camera(eye=tuple(origin), target=tuple(origin + normal), up=tuple(random.normal(size=3)),
                        fov=float(random.choice([5, 40, 75, 120])))
        width, height = random.integers(1, 48, 2)
        record = screen_record(Screen(camera=camera, width=int(width), height=int(height)), geometry.coordinates)
    return RandomFrustum(seed, geometry, record, cell)


def speckled_frustum(seed: int) -> RandomFrustum:
    """A frustum in a scene in which each ray has a speck of its own: near for most rays, far away for a few.

    So most rays settle early, and those that do not are isolated; no patch is in more than a few cells.
    """
    random = np.random.default_rng(seed)
    origin = random.uniform(0.3, 0.7, 3) * CELLS
    normal = random.normal(size=3)
    normal /= np.linalg.norm(normal)
    coordinates = GCoordinates.of(room(), CONFIG.numbers, [origin])
    if seed % 2:
        record = hemisphere_record(Hemisphere(64, 16), coordinates, origin, normal)
    else:
        camera = Camera(eye=tuple(origin), target=tuple(origin + normal), up=(0.3, 0.5, 0.7),
                        fov=float(random.choice([20, 60, 100])))
        record = screen_record(Screen(camera=camera, width=24, height=16), coordinates)
    local = record.all_directions() * ([*record.half_angles, record.slope_scale] if record.is_screen else 1)
    direction = (local @ record.to_global.T).astype(np.float64)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    with np.errstate(divide="ignore"):
        wall = np.maximum((0.2 - origin) / direction, (CELLS - 0.2 - origin) / direction).min(axis=1)
    distance = np.where(random.random(len(direction)) < random.choice([0.9, 0.97]),
                        random.uniform(1, 3, len(direction)), random.uniform(3, wall))
    # The specks of neighbouring rays do not touch.
    nearest = np.partition(np.linalg.norm(direction[:, None] - direction[None], axis=2), 1, axis=1)[:, 1]
    half = np.minimum(0.2 * nearest * distance, 0.1)
    side = np.cross(direction, random.normal(size=3))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(direction, side)
    square = np.stack([-side - other, side - other, side + other, other - side], axis=1)
    specks = (origin + distance[:, None] * direction)[:, None] + half[:, None, None] * square
    return RandomFrustum(seed, PatchGeometry.of(room(specks), CONFIG.numbers, [origin]), record, 1 / CELLS)


def room(vertices=()) -> Scene:
    """Patches in a room: two specks in its corners make the scene box the same whatever else there is."""
    speck = np.array([[0, 0, 0], [1e-3, 0, 0], [1e-3, 1e-3, 0], [0, 1e-3, 0]])
    builder = SceneBuilder("room")
    builder.add(np.concatenate([np.reshape(vertices, (-1, 4, 3)), [speck, CELLS - speck]]),
                Material(name="paint", diffuse=(0.5, 0.5, 0.5)))
    return builder.build()
