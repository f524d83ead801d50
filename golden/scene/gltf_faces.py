"""Triangles of a glTF primitive, and their colours."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.scene.appearance import UNSPECIFIED, colour_materials, from_srgb, to_srgb
from golden.scene.face_normals import contradicted
from golden.scene.gltf_buffers import GltfBuffers
from golden.scene.gltf_material import gltf_material
from golden.scene.material import Material
from golden.scene.texture import Texture, join_halves
from golden.scene.unused import NORMALS, Unused

__all__ = ["TRIANGLES", "GltfFaces", "gltf_faces"]

TRIANGLES = (4, 5, 6)
"""Modes of primitives that are read: triangles, their strips and their fans."""

TRANSFORM = "KHR_texture_transform"


@dataclass(frozen=True, kw_only=True, eq=False)
class GltfFaces:
    """The triangles of a primitive.

    Parameters
    ----------
    points, faces
        V x 3 vertices, and F x 3 numbers of the corners.
    materials, index, one_sided
        The materials, F indices into them, and whether the backs are black.
    texture, uv, colour
        The picture of what reflects, its F x 3 x 2 coordinates at the corners (None if the file states none), and the
        F x 3 linear colours that it has in the materials; None without a picture.
    """

    points: np.ndarray
    faces: np.ndarray
    materials: list[Material]
    index: np.ndarray
    one_sided: bool
    texture: Texture | None = None
    uv: np.ndarray | None = None
    colour: np.ndarray | None = None


def _corner_triangles(mode: int, count: int) -> np.ndarray:
    """F x 3 places of the corners among ``count`` ones of a mode; corners of an incomplete triangle are left out."""
    if mode == 4:
        return np.arange(count - count % 3).reshape(-1, 3)
    first = np.arange(max(0, count - 2))
    if mode == 6:
        return np.stack((np.zeros_like(first), first + 1, first + 2), axis=1)
    return np.stack((first, first + 1 + first % 2, first + 2 - first % 2), axis=1)


def gltf_faces(primitive: dict, where: str, tree: dict, buffers: GltfBuffers, unused: Unused) -> GltfFaces | None:
    """The triangles of a primitive; None if it has none.

    Parameters
    ----------
    primitive, where
        The glTF object, and its place for messages.
    tree, buffers
        The file's JSON part and its buffers.
    unused
        Counts what is not used.

    Raises
    ------
    InputError
        A corner is at a vertex that does not exist, or the buffers cannot be read.
    """
    attributes, mode = primitive.get("attributes", {}), primitive.get("mode", 4)
    if "POSITION" not in attributes or mode not in TRIANGLES:
        return None
    points = buffers.values(attributes["POSITION"], "VEC3").astype(np.float64)
    corners = np.arange(len(points))
    if "indices" in primitive:
        corners = buffers.values(primitive["indices"], "SCALAR")[:, 0]
        if corners.dtype.kind != "u":
            raise InputError(f"{where}.indices must be whole numbers without a sign")
        corners = corners.astype(np.int64)
    if len(corners) and corners.max() >= len(points):
        raise InputError(f"{where} has a corner at vertex {corners.max() + 1}, but {len(points)} vertices")
    faces = corners[_corner_triangles(mode, len(corners))]
    incomplete = len(corners) % 3 if mode == 4 else len(corners) * (len(corners) < 3)
    unused.add("corners of an incomplete triangle", incomplete)
    if mode == 5:  # triangles with a corner twice join the parts of a strip
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    if not len(faces):
        return None
    read = _Reader(points, faces, attributes, buffers, unused)
    read.check_normals()
    source = tree["materials"][primitive["material"]] if "material" in primitive else None
    return read.unnamed() if source is None else read.of(source, f"material {primitive['material']}")


class _Reader:
    """The materials of a primitive's triangles."""

    def __init__(self, points, faces, attributes, buffers, unused):
        self._points, self._faces, self._attributes = points, faces, attributes
        self._buffers, self._unused = buffers, unused
        self._vertex_colours = self._at_corners("COLOR_0", "VEC3", "VEC4")

    def _at_corners(self, name, *types):
        """F x 3 x W values of an attribute at the corners; None without it."""
        if name not in self._attributes:
            return None
        values = self._buffers.values(self._attributes[name], *types)
        if len(values) != len(self._points):
            raise InputError(f"attribute {name} has {len(values)} entries for {len(self._points)} vertices")
        # Some programs write integers without the mark that they are shares of the largest one.
        share = np.iinfo(values.dtype).max if name == "COLOR_0" and values.dtype.kind == "u" else 1
        return values.astype(np.float64)[self._faces] / share

    def check_normals(self) -> None:
        """Counts the faces whose normals contradict the order of their corners."""
        normals = self._at_corners("NORMAL", "VEC3")
        if normals is not None:
            self._unused.add(NORMALS, contradicted(
                self._points, np.full(len(self._faces), 3), self._faces.reshape(-1), normals.reshape(-1, 3)))

    def unnamed(self) -> GltfFaces:
        """Triangles without a material: glTF's default one is one-sided."""
        if self._vertex_colours is None:
            materials, index = [UNSPECIFIED], np.zeros(len(self._faces), dtype=np.int64)
        else:
            materials, index = colour_materials(self._mean_vertex_colours())
        return self._faces_with(list(materials), index, one_sided=True)

    def _mean_vertex_colours(self):
        return self._vertex_colours[..., :3].mean(axis=1)

    def of(self, source: dict, name: str) -> GltfFaces:
        """Triangles with a material; ``name`` is that of a material without one."""
        name, one_sided = str(source.get("name", name)), not source.get("doubleSided", False)
        pbr = source.get("pbrMetallicRoughness", {})
        (base, texture, uv), (glow, *_) = (self._textured(part.get(kind), kind) for part, kind in (
            (pbr, "baseColorTexture"), (source, "emissiveTexture")))
        blends = source.get("alphaMode") == "BLEND"
        self._unused.add("alpha of a texture", blends and texture is not None and texture.has_alpha)
        colours = self._vertex_colours
        if colours is not None:
            self._unused.add("alpha of vertices", blends and colours.shape[2] > 3 and bool((colours[..., 3] < 1).any()))
            colours = self._mean_vertex_colours()
            base = colours if base is None else base * colours
        if base is None and glow is None:
            return self._faces_with([gltf_material(source, name)], np.zeros(len(self._faces), dtype=np.int64),
                                    one_sided=one_sided)
        both = np.hstack([np.ones((len(self._faces), 3)) if part is None else part for part in (base, glow)])
        # As `colour_materials` does, a material for each different colour in 8 bits.
        steps, index = np.unique(np.rint(255 * to_srgb(both)).astype(np.int64), axis=0, return_inverse=True)
        index = index.reshape(-1)
        tints = [] if len(steps) == 1 else [" #{:02x}{:02x}{:02x}".format(*row) for row in steps[:, :3].tolist()]
        values = from_srgb(steps / 255)
        materials = [gltf_material(source, name + tint, colour=row[:3], emission_colour=row[3:])
                     for tint, row in zip(tints or [""], values, strict=True)]
        colour = values[index, :3] / (1 if colours is None else np.where(colours > 0, colours, 1))
        return self._faces_with(materials, index, one_sided=one_sided, texture=texture, uv=uv, colour=colour)

    def _faces_with(self, materials, index, **more):
        return GltfFaces(points=self._points, faces=self._faces, materials=materials, index=index, **more)

    def _textured(self, info, kind):
        """F x 3 linear means of a texture over the triangles, the texture, and its coordinates; each may be None."""
        texture = None if info is None else self._buffers.texture(info["index"], kind)
        if texture is None:
            return None, None, None
        self._unused.add(f"further frames of {kind}", texture.has_frames)
        transform = info.get("extensions", {}).get(TRANSFORM, {})
        uv = self._at_corners(f"TEXCOORD_{transform.get('texCoord', info.get('texCoord', 0))}", "VEC2")
        if uv is None:
            self._unused.add("texture of a face without coordinates", len(self._faces))
            return np.tile(texture.mean(), (len(self._faces), 1)), texture, None
        turn = transform.get("rotation", 0.0)
        uv = uv * transform.get("scale", (1, 1)) @ [(np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn))]
        uv += transform.get("offset", (0, 0))
        uv[..., 1] = 1 - uv[..., 1]  # glTF counts from the upper border
        return join_halves(self._points[self._faces], texture.means(uv)), texture, uv
