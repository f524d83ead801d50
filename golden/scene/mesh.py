"""Polygons of files, and the scene that they become."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.input_warnings import warn
from golden.scene.adjacency import corner_sets, inside_out, patch_normals, smooth_numbers, surface_numbers
from golden.scene.face_normals import area_vectors
from golden.scene.material import Material
from golden.scene.polygons import crosses_itself, cut_polygon, merge_triangles, split_nonplanar
from golden.scene.scene import Scene
from golden.scene.textures import Textures

__all__ = ["CREASE", "FARTHEST", "Mesh", "check_mesh", "mesh_scene"]

CREASE = 30.0
"""Least angle between neighbouring patches, in degrees, at which their common edge is a crease."""

MOST_CORNERS = 1 << 14
"""Most corners of a face: the time to cut it grows faster than their number."""

FARTHEST = 1e30
"""Largest coordinate: areas and the intensities of such a scene are finite."""

NO_AREA = 1e-12
"""Largest area of a face, over the square of its extent, that counts as zero."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Geometry of a file.

    Parameters
    ----------
    points
        V x 3 float64, vertices.
    counts
        F int64, number of corners of each face.
    corners
        Vertex numbers of all faces, one face after the other.
    material
        F indices into ``materials``.
    materials
        The materials.
    one_sided
        For each material, whether the backs of its faces are black.
    textures
        Pictures on the faces, or None.
    files
        Further files that the file names and that were read.
    """

    points: np.ndarray
    counts: np.ndarray
    corners: np.ndarray
    material: np.ndarray
    materials: tuple[Material, ...]
    one_sided: np.ndarray
    textures: Textures | None = None
    files: tuple[Path, ...] = ()


def check_mesh(mesh: Mesh, where: str) -> None:
    """A mesh has faces, each with an area and with three corners or more at finite vertices.

    Raises
    ------
    InputError
        It has not; faces and vertices are counted from 1.
    """
    _check_corners(mesh, where)
    flat = _flat(mesh)
    if len(flat):
        raise InputError(f"{where}: {_faces(flat)} no area")


def _check_corners(mesh: Mesh, where: str) -> None:
    if not len(mesh.counts):
        raise InputError(f"{where}: it has no faces")
    long = np.flatnonzero(mesh.counts > MOST_CORNERS)
    if len(long):
        raise InputError(f"{where}: face {long[0] + 1} has {mesh.counts[long[0]]} corners, at most {MOST_CORNERS} are "
                         "read")
    short = np.flatnonzero(mesh.counts < 3)
    if len(short):
        raise InputError(f"{where}: face {short[0] + 1} has {mesh.counts[short[0]]} corners, three at least are needed")
    starts = np.cumsum(mesh.counts) - mesh.counts
    wrong = np.flatnonzero((mesh.corners < 0) | (mesh.corners >= len(mesh.points)))
    if len(wrong):
        face, corner = np.searchsorted(starts, wrong[0], "right"), int(mesh.corners[wrong[0]])
        which = f"vertex {corner + 1}" if corner >= 0 else f"a negative number, {corner}"
        raise InputError(f"{where}: face {face} has a corner at {which}, but there are {len(mesh.points)} vertices")
    bad = np.flatnonzero(~np.isfinite(mesh.points).all(axis=1))
    if len(bad):
        raise InputError(f"{where}: vertex {bad[0] + 1} is not finite: {_numbers(mesh.points[bad[0]])}")
    far = np.flatnonzero((np.abs(mesh.points) > FARTHEST).any(axis=1))
    if len(far):
        raise InputError(f"{where}: vertex {far[0] + 1} is beyond {FARTHEST:g}: {_numbers(mesh.points[far[0]])}")


def _flat(mesh: Mesh) -> np.ndarray:
    """The faces without area."""
    starts = np.cumsum(mesh.counts) - mesh.counts
    local = mesh.points[mesh.corners] - np.repeat(mesh.points[mesh.corners[starts]], mesh.counts, axis=0)
    areas = 0.5 * np.linalg.norm(area_vectors(mesh.points, mesh.counts, mesh.corners), axis=1)
    extent = np.maximum.reduceat(np.abs(local).max(axis=1), starts)
    return np.flatnonzero(~(areas > NO_AREA * extent * extent))


def _faces(flat: np.ndarray) -> str:
    others = f" and {len(flat) - 1} more" if len(flat) > 1 else ""
    return f"face {flat[0] + 1}{others} {'have' if others else 'has'}"



def _numbers(values) -> str:
    return " ".join(f"{value:g}" for value in values)


def _cut(mesh: Mesh, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Patches (planar, convex) and the face of each, in the order of the faces; none of faces without area."""
    starts = np.cumsum(mesh.counts) - mesh.counts
    flat = _flat(mesh)
    if len(flat) == len(mesh.counts):
        raise InputError(f"{where}: {_faces(flat)} no area")
    if len(flat):
        warn(f"not used: {_faces(flat)} no area")
    counts = mesh.counts.copy()
    counts[flat] = 0
    patches, faces = [], []
    for count, picks in ((3, (0, 1, 2, 2)), (4, (0, 1, 2, 3))):
        chosen = np.flatnonzero(counts == count)
        patches.append(mesh.points[mesh.corners[starts[chosen, None] + picks]])
        faces.append(chosen)
    no_quad = (patches[1] == np.roll(patches[1], 1, axis=1)).all(axis=2).any(axis=1) | crosses_itself(patches[1])
    by_hand = np.concatenate((faces[1][no_quad], np.flatnonzero(counts > 4)))
    patches[1], parents = split_nonplanar(patches[1][~no_quad])
    faces[1] = faces[1][~no_quad][parents]
    for face in by_hand.tolist():
        try:
            pieces = cut_polygon(mesh.points[mesh.corners[starts[face]:starts[face] + mesh.counts[face]]])
        except InputError as error:
            raise InputError(f"{where}: face {face + 1}: {error}") from error
        patches.append(pieces)
        faces.append(np.full(len(pieces), face))
    faces = np.concatenate(faces)
    order = np.argsort(faces, kind="stable")
    return np.concatenate(patches)[order], faces[order]


def _without_duplicates(patches: np.ndarray, face: np.ndarray, mesh: Mesh):
    """Patches without those in the place of an earlier one, their faces, the face on the back of each or -1, and sides.

    Of each place the first patch counts, and the first one that faces the other way if both materials are opaque and
    they or their pictures differ.
    """
    material = mesh.material[face]

    def differ(one, other):
        result = material[one] != material[other]
        if mesh.textures is not None:
            result |= ~mesh.textures.alike(face[one], face[other], patches[one])
        return result

    one_sided = mesh.one_sided[material]
    _, first, place = np.unique(corner_sets(patches), axis=0, return_index=True, return_inverse=True)
    place = place.reshape(-1)
    behind = np.full(len(first), -1)
    if len(first) < len(patches):
        normals, _ = patch_normals(patches)
        opposite = np.flatnonzero(np.einsum("ij,ij->i", normals, normals[first][place]) < 0)
        behind[place[opposite[::-1]]] = opposite[::-1]  # of several values the last one stays
        is_opaque = np.array([not any(it.transparent) for it in mesh.materials])[material]
        is_pair = (behind >= 0) & differ(behind, first) & is_opaque[behind] & is_opaque[first]
        one_sided[first[behind >= 0]] = is_pair[behind >= 0]
        behind[~is_pair] = -1
        facing = first[place]
        facing[opposite] = np.where(is_pair, behind, first)[place[opposite]]
        others = int(differ(np.arange(len(patches)), facing).sum())
        if others:
            warn(f"not used: faces in the place of an earlier one of another material or picture ({others})")
    order = np.argsort(first)
    kept, behind = first[order], behind[order]
    return patches[kept], face[kept], np.where(behind < 0, -1, face[behind]), one_sided[kept]


def _alike(textures: Textures | None, *faces: np.ndarray):
    """Function of pairs of patches: whether their pictures go on across them, on each of their sides' faces."""
    if textures is None:
        return None
    sides = [textures.of(side) for side in faces]
    return lambda *pairs: np.logical_and.reduce([side.alike(*pairs) for side in sides])


def mesh_scene(mesh: Mesh, *, name: str, where: str, **properties) -> Scene:
    """The scene of a mesh.

    Faces become patches: polygons are cut (`cut_polygon`), non-planar quads split (`split_nonplanar`), and if the mesh
    has triangles only, those that are the halves of a quad, in their texture coordinates too, are merged
    (`merge_triangles`). Faces with the corners of an earlier one, in any rotation, are dropped; if one faced the other
    way, the first becomes two-sided, or, if the two are of different opaque materials or pictures, both are kept and
    one-sided.
    Patches of one material that are connected by edges are one surface if they are coplanar, and one smooth group if
    their angle is below `CREASE`; patches back to back are one surface. Closed bodies that refract are oriented so that
    their fronts face outwards.

    Parameters
    ----------
    name, properties
        See `Scene`.
    where
        The file's path, for messages.

    Raises
    ------
    InputError
        No faces with an area, faces with less than three corners, corners at vertices that do not exist, vertices
        that are not finite or beyond `FARTHEST`, polygons that cross themselves. Faces and vertices are counted from 1.

    Warns
    -----
    InputWarning
        Faces without area are left out, and faces in the place of an earlier one of another material or
        picture.
    """
    _check_corners(mesh, where)
    patches, face = _cut(mesh, where)
    patches, face, behind, one_sided = _without_duplicates(patches, face, mesh)
    if (mesh.counts == 3).all():
        other = np.where(behind < 0, face, behind)
        sides = np.unique(np.stack([mesh.material[face], mesh.material[other], one_sided]), axis=1,
                          return_inverse=True)[1].reshape(-1)
        patches, surface, parent = merge_triangles(patches[:, :3], sides, alike=_alike(mesh.textures, face, other))
        face, behind, one_sided = face[parent], behind[parent], one_sided[parent]
    else:
        surface = surface_numbers(patches, mesh.material[face])
    double = np.flatnonzero(behind >= 0)
    patches = np.concatenate([patches, patches[double][:, [1, 0, 3, 2]]])
    face, surface, one_sided = (np.concatenate(parts) for parts in (
        (face, behind[double]), (surface, surface[double]), (one_sided, one_sided[double])))
    order = np.argsort(face, kind="stable")
    patches, face, surface, one_sided = patches[order], face[order], surface[order], one_sided[order]
    material, textures = mesh.material[face], None if mesh.textures is None else mesh.textures.of(face)
    bends = np.array([it.refraction_index > 1 and not it.thin and max(it.transparent) > 0
                      for it in mesh.materials])[material]
    turned = bends & inside_out(patches, material)
    patches[turned] = patches[turned][:, [1, 0, 3, 2]]  # a triangle still ends in its repeated vertex
    used, material = np.unique(material, return_inverse=True)
    return Scene(name=name, vertices=patches, material=material.reshape(-1),
                 materials=tuple(mesh.materials[number] for number in used), surface=surface,
                 smooth=smooth_numbers(patches, material, crease=CREASE), two_sided=~one_sided,
                 textures=textures, files=mesh.files, **properties)
