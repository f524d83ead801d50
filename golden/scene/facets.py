"""Scenes whose surfaces are the faces of a file, one by one."""

import numpy as np

from golden.base.errors import InputError
from golden.scene.adjacency import FLAT, rounded_sine
from golden.scene.mesh import Mesh, check_mesh
from golden.scene.polygons import cut_polygon, is_convex_quad
from golden.scene.scene import Scene

__all__ = ["facet_scene"]


def facet_scene(mesh: Mesh, *, name: str, where: str, **properties) -> Scene:
    """The scene of a mesh whose faces stay as they are, and only fronts radiate.

    A triangle or a convex quad is one patch, any other polygon is several (`cut_polygon`): ``surface`` has the number
    of each patch's face, in the file's order.

    Parameters
    ----------
    name, properties
        See `Scene`.
    where
        The file's path, for messages.

    Raises
    ------
    InputError
        A face is not planar, crosses itself or has no area; or anything that `golden.scene.mesh.check_mesh` refuses.
        Faces are counted from 1.
    """
    check_mesh(mesh, where)
    starts = np.cumsum(mesh.counts) - mesh.counts
    patches = mesh.points[mesh.corners[starts[:, None] + np.minimum([0, 1, 2, 3], mesh.counts[:, None] - 1)]]
    is_patch = mesh.counts == 3
    quads = np.flatnonzero(mesh.counts == 4)
    is_patch[quads] = is_convex_quad(patches[quads])
    parts, faces = [patches[is_patch]], [np.flatnonzero(is_patch)]
    for face in np.flatnonzero(~is_patch).tolist():
        try:
            parts.append(_cut(mesh.points[mesh.corners[starts[face]:starts[face] + mesh.counts[face]]]))
        except InputError as error:
            raise InputError(f"{where}: facet {face + 1}: {error}") from error
        faces.append(np.full(len(parts[-1]), face))
    face = np.concatenate(faces)
    order = np.argsort(face, kind="stable")
    return Scene(name=name, vertices=np.concatenate(parts)[order], material=mesh.material[face[order]],
                 materials=tuple(mesh.materials), surface=face[order], files=mesh.files, **properties)


def _cut(points):
    """The patches of a planar polygon."""
    local = points - points.mean(axis=0)
    vector = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
    height = np.abs(local @ vector) / np.linalg.norm(vector)
    extent, reach = np.ptp(points, axis=0).max(), np.abs(points).max()
    if height.max() > extent * (FLAT + rounded_sine(reach, np.array([extent]))[0]):
        raise InputError("it is not planar")
    return cut_polygon(points)
