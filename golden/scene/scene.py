"""Scenes: patches, materials, lights and a camera."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.plural import counted
from golden.scene.camera import Camera
from golden.scene.facet_fields import facet_fields
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.material import BRIGHTEST, Material, Rgb
from golden.scene.sky.sky import Sky
from golden.scene.textures import Textures

__all__ = ["Scene"]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Scene:
    """Patches with their materials: planar, strictly convex quadrilaterals and triangles.

    A triangle repeats its last vertex (``vertices[i, 3] == vertices[i, 2]``). Neighbouring patches have the same
    float64 coordinates at a shared corner, so that casting loses no ray between them. The front of a patch is
    the side from which its vertices run counter-clockwise.

    A scene does not change: its arrays, and those that follow from them, are read-only.

    Parameters
    ----------
    name
        Name in summaries and of files.
    vertices
        N x 4 x 3 float64, scene units.
    material
        N int32, index into ``materials``.
    materials
        The materials.
    surface
        N int32. Patches that were cut from one planar polygon have the same number; a ray that starts on a surface
        never hits that surface. Default: every patch its own.
    smooth
        N int32. Patches with the same number approximate one curved surface: shading normals and radiosities are
        continuous across the edges between them. Default: the same as ``surface``.
    two_sided
        N bool. Whether the back of the patch reflects and emits like its front; the back of a one-sided patch is
        black. Both sides block. Of two one-sided patches back to back, with the same corners and opposite fronts, a ray
        hits the one whose front faces it. Default: all one-sided.
    camera
        View of the scene, or None.
    lights
        Lights without an area (area lights are patches whose material emits).
    background
        Radiance along rays that leave the scene: the same in all directions, or a sky.
    up
        Up direction of the default camera.
    textures
        Pictures on the patches, or None.
    files
        The file that it was read from, and the libraries, buffers and pictures that this names and that were read.

    Raises
    ------
    InputError
        Arrays of the wrong shape, no patches, vertices that are not finite, or material numbers or a background out of
        range.
    """

    name: str
    vertices: np.ndarray
    material: np.ndarray
    materials: tuple[Material, ...]
    # None is replaced by what it stands for.
    surface: np.ndarray = None  # type: ignore[assignment]
    smooth: np.ndarray = None  # type: ignore[assignment]
    two_sided: np.ndarray = None  # type: ignore[assignment]
    camera: Camera | None = None
    lights: tuple[PointLight | DirectionalLight, ...] = ()
    background: Rgb | Sky = (0.0, 0.0, 0.0)
    up: tuple[float, float, float] = field(default=(0.0, 0.0, 1.0))
    textures: Textures | None = None
    files: tuple[Path, ...] = ()

    def __post_init__(self):
        vertices = np.ascontiguousarray(self.vertices, dtype=np.float64)
        if vertices.ndim != 3 or vertices.shape[1:] != (4, 3):
            raise InputError(f"scene {self.name!r}: Vertices must be N x 4 x 3, not {vertices.shape!r}")
        count = len(vertices)
        if count == 0:
            raise InputError(f"scene {self.name!r}: it has no patches")
        bad = np.flatnonzero(~np.isfinite(vertices).all(axis=(1, 2)))
        if len(bad):
            raise InputError(f"scene {self.name!r}: patch {bad[0]} has a vertex that is not finite")
        defaults = {"surface": np.arange(count), "smooth": self.surface if self.smooth is None else None,
                    "two_sided": np.zeros(count, dtype=bool)}
        if self.smooth is None and self.surface is None:
            defaults["smooth"] = np.arange(count)
        object.__setattr__(self, "vertices", _constant(vertices))
        for name in ("material", "surface", "smooth", "two_sided"):
            value = getattr(self, name)
            value = np.ascontiguousarray(defaults[name] if value is None else value,
                                         dtype=bool if name == "two_sided" else np.int32)
            if value.shape != (count,):
                raise InputError(f"scene {self.name!r}: {name.capitalize()} must have one entry for each of "
                                 f"{count} patches, not shape {value.shape!r}")
            object.__setattr__(self, name, _constant(value))
        if self.material.min() < 0 or self.material.max() >= len(self.materials):
            raise InputError(f"scene {self.name!r}: Material must be a number below {len(self.materials)}, "
                             f"not {self.material.min()} to {self.material.max()}")
        if not isinstance(self.background, Sky) and not 0 <= min(self.background) <= max(self.background) <= BRIGHTEST:
            raise InputError(f"scene {self.name!r}: Background must be at least 0 and at most {BRIGHTEST:g}, not "
                             f"{self.background!r}")
        if self.textures is not None and len(self.textures) != count:
            raise InputError(f"scene {self.name!r}: Textures must have one entry for each of {count} patches, not "
                             f"{len(self.textures)}")

    @classmethod
    def from_arrays(cls, vertices, faces=None, *, names=None, materials: Mapping[str, Material] | None = None,
                    two_sided: bool = False, **more) -> "Scene":
        """The scene of N facets, one patch each.

        Parameters
        ----------
        vertices
            N x 3 x 3 or N x 4 x 3 corners, counter-clockwise as seen from the front; with ``faces`` P x 3 points.
        faces
            N x 3 or N x 4 numbers of points.
        names
            N names of surfaces. Default: one name for all.
        materials
            The material of each name. Default, and of other names: half of the light is reflected diffusely.
        two_sided
            Whether backs radiate like fronts.
        more
            Further arguments: ``name``, ``camera``, ``lights``, ``background``, ``up``.

        Raises
        ------
        InputError
            Shapes do not match; a facet is not planar, not strictly convex, or has no area.
        """
        return cls(**facet_fields(vertices, faces, names, materials, two_sided), **{"name": "facets", **more})

    @classmethod
    def from_trimesh(cls, mesh, **more) -> "Scene":
        """The scene of a `trimesh.Trimesh`, a patch for each triangle; the others as of `from_arrays`."""
        return cls.from_arrays(mesh.vertices, mesh.faces, **more)

    @classmethod
    def from_pyvista(cls, mesh, **more) -> "Scene":
        """The scene of a `pyvista.PolyData` of triangles and quadrilaterals; the others as of `from_arrays`.

        ``names`` may be the name of an array of the mesh's cells.

        Raises
        ------
        InputError
            A face has more than four corners.
        """
        faces, corners, first = np.asarray(mesh.faces), [], 0
        while first < len(faces):
            count = int(faces[first])
            if count not in (3, 4):
                raise InputError(f"geometry: Faces must have three or four corners, not {count}", parameter="mesh")
            corners.append(faces[first + np.minimum(np.arange(1, 5), count)])
            first += 1 + count
        if isinstance(more.get("names"), str):
            more["names"] = mesh.cell_data[more["names"]]
        return cls.from_arrays(mesh.points, np.reshape(corners, (-1, 4)).astype(np.int64), **more)

    def __repr__(self) -> str:
        low, high = self.bounds
        lights = len(self.lights) + sum(material.emits for material in self.materials)
        return (f"<Scene {self.name!r}: {counted(len(self), 'patch')}, {counted(len(self.materials), 'material')}, "
                f"{counted(lights, 'light')}, {' x '.join(f'{side:g}' for side in high - low)}>")

    def __len__(self) -> int:
        return len(self.vertices)

    def __getstate__(self) -> dict:
        """The fields alone: what follows from them is computed anew."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def with_parts(self, parent: np.ndarray, vertices: np.ndarray | None = None) -> "Scene":
        """The scene of patches, or of parts of them.

        Parameters
        ----------
        parent
            K int or N bool: the patches.
        vertices
            K x 4 x 3 corners of parts of them. Default: the whole patches.
        """
        columns = {name: getattr(self, name)[parent] for name in ("material", "surface", "smooth", "two_sided")}
        return replace(self, vertices=self.vertices[parent] if vertices is None else vertices, **columns,
                       textures=None if self.textures is None else self.textures.of(parent))

    def __setstate__(self, state):
        vars(self).update(state)
        for name in ("vertices", "material", "surface", "smooth", "two_sided"):
            state[name].setflags(write=False)

    @property
    def has_sky(self) -> bool:
        """Whether its background shines."""
        return isinstance(self.background, Sky) or any(self.background)

    @property
    def is_lit(self) -> bool:
        """Whether it has a light of any kind."""
        return bool(self.lights) or self.has_sky or bool(self.channels("emission").any())

    def background_along(self, direction: np.ndarray) -> np.ndarray:
        """Radiance along K x 3 vectors that leave the scene, K x 3."""
        if isinstance(self.background, Sky):
            return self.background.radiance(direction)
        return np.tile(np.asarray(self.background, dtype=np.float64), (len(direction), 1))

    @cached_property
    def is_triangle(self) -> np.ndarray:
        """N bool: the patch is a triangle."""
        return _constant((self.vertices[:, 3] == self.vertices[:, 2]).all(axis=1))

    @cached_property
    def centres(self) -> np.ndarray:
        """N x 3: the mean of each patch's corners; a triangle's repeated one counts once."""
        share = np.where(self.is_triangle[:, None], [1 / 3, 1 / 3, 1 / 3, 0], 0.25)
        return _constant(np.einsum("nk,nkj->nj", share, self.vertices))

    @cached_property
    def area_vectors(self) -> np.ndarray:
        """N x 3: front normal times area."""
        v = self.vertices
        return _constant(0.5 * np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1]))

    @cached_property
    def areas(self) -> np.ndarray:
        """N float64, areas in squared scene units."""
        return _constant(np.linalg.norm(self.area_vectors, axis=1))

    @cached_property
    def normals(self) -> np.ndarray:
        """N x 3 unit front normals."""
        return _constant(self.area_vectors / self.areas[:, None])

    @cached_property
    def is_curved(self) -> np.ndarray:
        """N bool: the patch's smooth group is more than one plane."""
        group, _ = np.unique(np.stack([self.smooth, self.surface]), axis=1)
        return _constant(np.bincount(group, minlength=self.smooth.max() + 1)[self.smooth] > 1)

    @cached_property
    def bounds(self) -> np.ndarray:
        """2 x 3: lower and upper corner of the scene box."""
        points = self.vertices.reshape(-1, 3)
        return _constant(np.array([points.min(axis=0), points.max(axis=0)]))

    @cached_property
    def size(self) -> float:
        """The scene box's longest side."""
        return float((self.bounds[1] - self.bounds[0]).max())

    @cached_property
    def behind(self):
        """N int32: the patch back to back with each, or itself; None if there are no such pairs."""
        single = np.flatnonzero(~self.two_sided)
        corners = self.vertices[single] + 0.0  # -0 becomes 0
        # Equal boxes have equal sums modulo 2^64; few others have.
        box = np.concatenate([corners.min(axis=1), corners.max(axis=1)], axis=1).view(np.uint64)
        key = box @ np.array([0x9E3779B97F4A7C15 * odd % 2**64 for odd in (1, 3, 5, 7, 9, 11)], dtype=np.uint64)
        order = np.argsort(key, kind="stable")
        again = np.diff(key[order]) == 0
        rows = single[order[np.append(again, False) | np.append(False, again)]] if len(order) else order
        if not len(rows):
            return None
        from golden.scene.adjacency import corner_sets  # slow

        _, place = np.unique(corner_sets(self.vertices[rows]), axis=0, return_inverse=True)
        order = np.argsort(place.reshape(-1), kind="stable")
        rows, place = rows[order], place.reshape(-1)[order]
        found = np.arange(len(self), dtype=np.int32)
        pair = np.flatnonzero((np.diff(place) == 0)
                              & (np.einsum("ij,ij->i", self.normals[rows[:-1]], self.normals[rows[1:]]) < 0))
        if not len(pair):
            return None
        one, other = rows[pair], rows[pair + 1]
        found[one], found[other] = other, one
        return _constant(found)

    def facing(self, patch: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """The patches that K rays hit which meet these, K int32, or -1: of two back to back the one that faces the ray.

        Parameters
        ----------
        patch
            K int: a patch that is first along each ray, or -1.
        direction
            K x 3, of the rays.
        """
        if self.behind is None:
            return patch
        is_back = np.einsum("ki,ki->k", self.normals[patch], direction) > 0
        return np.where(is_back & (patch >= 0), self.behind[patch], patch)

    def channels(self, name: str) -> np.ndarray:
        """A material property (``"diffuse"``, ``"emission"``, ...) of every patch, N x 3 (or N)."""
        return np.array([getattr(material, name) for material in self.materials], dtype=np.float64)[self.material]


def _constant(array):
    """A read-only array: the given one, or a copy if it can be written."""
    if array.flags.writeable:
        array = array.copy()
        array.setflags(write=False)
    return array
