"""Torus scene: spheres, polygons and lights in the coordinates of a camera."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from golden.base.errors import InputError
from golden.cast.default_camera import default_camera
from golden.scene.scene import Scene

__all__ = ["AMBIENT", "DIFFUSE", "INDEX", "MIRROR", "TRANSPARENT", "Objects", "TorusScene", "torus_scene"]

AMBIENT, DIFFUSE, MIRROR, TRANSPARENT, INDEX = 0, 3, 6, 9, 12
"""Columns of coefficients; the first four have three channels."""

# Share of a patch's diffuse reflectance that answers to ambient light: the source has no value.
_AMBIENT_SHARE = 0.1


class Objects(NamedTuple):
    """Objects and lights, which compiled functions read.

    Parameters
    ----------
    corners
        N x 4 x 3 float64. Of a sphere the first row is its centre, and the first number of the second its radius.
    counts
        N int64: corners of a polygon, 3 or 4; 0 of a sphere.
    normals
        N x 3 float64; 0 of a sphere.
    coefficients
        N x 13 float64, see the columns.
    lights
        L x 7 float64: position, radius and colour.
    """

    corners: np.ndarray
    counts: np.ndarray
    normals: np.ndarray
    coefficients: np.ndarray
    lights: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class TorusScene:
    """Objects in front of an eye at the origin, which looks along z; x runs to the right, y up.

    Polygons are convex, with three or four corners. An object reflects from both sides. A light of radius 0 is never
    hit.

    Parameters
    ----------
    name
        Name in reports.
    corners, counts, coefficients, lights
        See `Objects`.
    slope
        Half the height of the picture over the distance: the tangent of half the vertical field of view.

    Raises
    ------
    InputError
        There are no objects, a radius is not positive, or a polygon has no area.
    """

    name: str
    corners: np.ndarray
    counts: np.ndarray
    coefficients: np.ndarray
    lights: np.ndarray
    slope: float

    def __post_init__(self):
        for name in ("corners", "coefficients", "lights"):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=np.float64))
        object.__setattr__(self, "counts", np.ascontiguousarray(self.counts, dtype=np.int64))
        if not len(self.counts):
            raise InputError(f"scene {self.name!r}: it has no objects")
        size = np.where(self.counts == 0, self.corners[:, 1, 0], np.linalg.norm(self._area_vectors(), axis=1))
        bad = np.flatnonzero(~(size > 0))
        if len(bad):
            raise InputError(f"scene {self.name!r}: Object {bad[0]} must have a positive size, not {size[bad[0]]:g}")

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def objects(self) -> Objects:
        """Arrays for compiled functions."""
        vectors = self._area_vectors()
        length = np.linalg.norm(vectors, axis=1)
        normals = np.where(self.counts[:, None] == 0, 0.0, vectors / np.where(length > 0, length, 1)[:, None])
        return Objects(corners=self.corners, counts=self.counts, normals=normals, coefficients=self.coefficients,
                       lights=self.lights)

    @property
    def bounds(self) -> np.ndarray:
        """N x 2 x 3: the least and the largest coordinates of each object."""
        centre, radius = self.corners[:, 0], self.corners[:, 1, :1]
        is_sphere = (self.counts == 0)[:, None]
        return np.stack([np.where(is_sphere, centre - radius, self.corners.min(axis=1)),
                         np.where(is_sphere, centre + radius, self.corners.max(axis=1))], axis=1)

    def _area_vectors(self):
        one, two, three, four = np.moveaxis(self.corners, 1, 0)
        return 0.5 * np.cross(three - one, four - two)


def torus_scene(scene: Scene) -> TorusScene:
    """A scene of patches, seen by its camera.

    Specular reflectances mirror, transparent ones transmit. Point lights are lights of radius 0, and so is the centre
    of each patch that emits, moved from its front by a thousandth of the scene's size. Colours are scaled so that the
    brightest is 1, since light does not fade with distance here; a patch that emits has its own as ambient light. Other
    lights, the sky and textures do not count.

    Raises
    ------
    InputError
        The scene has no light.
    """
    camera = scene.camera or default_camera(scene)
    axes, eye = camera.axes, np.array(camera.eye)
    corners = (scene.vertices - eye) @ axes.T
    diffuse = scene.channels("diffuse")
    emission, size = scene.channels("emission"), np.ptp(scene.vertices, axis=(0, 1)).max()
    found = [(centre + 1e-3 * size * normal, colour) for centre, normal, colour in
             zip(scene.centres, scene.normals, emission, strict=True) if colour.any()]
    found += [(np.array(one.position), np.array(one.intensity)) for one in scene.lights if hasattr(one, "position")]
    if not found:
        raise InputError(f"scene {scene.name!r}: it has no light with a position")
    brightest = max(float(colour.max()) for _, colour in found)
    coefficients = np.concatenate([
        _AMBIENT_SHARE * diffuse + emission / brightest, diffuse, scene.channels("specular"),
        scene.channels("transparent"), scene.channels("refraction_index")[:, None]], axis=1)
    lights = [[*((position - eye) @ axes.T), 0.0, *(colour / brightest / len(found))] for position, colour in found]
    return TorusScene(name=scene.name, corners=corners, counts=np.where(scene.is_triangle, 3, 4),
                      coefficients=coefficients, lights=np.array(lights),
                      slope=float(np.tan(np.deg2rad(camera.fov) / 2)))
