"""Scenes whose patches are the faces of a file, one by one."""

import numpy as np

from golden.errors import InputError
from golden.scene.adjacency import patch_normals
from golden.scene.mesh import Mesh, check_mesh
from golden.scene.polygons import is_convex_quad
from golden.scene.scene import Scene

__all__ = ["check_facets", "facet_scene"]


def check_facets(patches: np.ndarray, where: str) -> None:
    """N x 4 x 3 patches, a triangle repeating its last vertex, are planar, strictly convex and have areas.

    Raises
    ------
    InputError
        One is not; facets are counted from 1.
    """
    quads = np.flatnonzero((patches[:, 3] != patches[:, 2]).any(axis=1))
    bent = quads[~is_convex_quad(patches[quads])]
    if len(bent):
        raise InputError(f"{where}: facet {bent[0] + 1} is not planar and strictly convex")
    flat = np.flatnonzero(patch_normals(patches)[1] == 0)
    if len(flat):
        raise InputError(f"{where}: facet {flat[0] + 1} has no area")


def facet_scene(mesh: Mesh, *, name: str, where: str, **properties) -> Scene:
    """The scene of a mesh whose faces stay as they are: patch k is face k, and only fronts radiate.

    Parameters
    ----------
    name, properties
        See `Scene`.
    where
        The file's path, for messages.

    Raises
    ------
    InputError
        A face has neither three nor four corners, is not planar, not strictly convex or has no area; or anything that
        `golden.scene.mesh.check_mesh` refuses. Faces are counted from 1.
    """
    check_mesh(mesh, where)
    many = np.flatnonzero(mesh.counts > 4)
    if len(many):
        raise InputError(f"{where}: facet {many[0] + 1} has {mesh.counts[many[0]]} corners, a facet has three or four")
    starts = np.cumsum(mesh.counts) - mesh.counts
    patches = mesh.points[mesh.corners[starts[:, None] + np.minimum([0, 1, 2, 3], mesh.counts[:, None] - 1)]]
    check_facets(patches, where)
    return Scene(name=name, vertices=patches, material=mesh.material, materials=tuple(mesh.materials),
                 files=mesh.files, **properties)
