"""The fields of scenes of vertices and meshes that a program has."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from golden.base.errors import InputError
from golden.scene.adjacency import patch_normals
from golden.scene.appearance import UNSPECIFIED
from golden.scene.material import Material
from golden.scene.polygons import is_convex_quad

__all__ = ["check_facets", "facet_fields"]


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


def facet_fields(geometry, faces, names, materials: Mapping[str, Material] | None, two_sided: bool) -> dict:
    """Vertices, materials and sides of facets in their order, by name; see `golden.scene.scene.Scene.from_arrays`.

    Raises
    ------
    InputError
        Shapes do not match; a facet is not planar, not strictly convex, or has no area.
    """
    if not isinstance(two_sided, bool | np.bool_):
        raise InputError(f"geometry: Two sided must be True or False, not {two_sided!r}", parameter="two_sided")
    vertices = _corners(geometry, faces)
    check_facets(vertices, "geometry")
    count = len(vertices)
    names = [UNSPECIFIED.name] * count if names is None else [str(name) for name in names]
    if len(names) != count:
        raise InputError(f"geometry: Names must be one for each of {count} facets, not {len(names)}", parameter="names")
    known = {name: number for number, name in enumerate(dict.fromkeys(names))}
    return {"vertices": vertices, "material": [known[name] for name in names], "two_sided": np.full(count, two_sided),
            "materials": tuple(replace((materials or {}).get(name, UNSPECIFIED), name=name) for name in known)}


def _corners(geometry, faces):
    """N x 4 x 3 corners."""
    try:
        vertices = np.asarray(getattr(geometry, "triangles", geometry), dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("geometry: Geometry must be a Scene, a mesh of triangles or N x 3 x 3 or N x 4 x 3 "
                         f"vertices, not {type(geometry).__name__}", parameter="geometry") from None
    if faces is not None:
        corners = np.asarray(faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or corners.ndim != 2 or corners.dtype.kind not in "iu":
            raise InputError("geometry: Faces must be N x 3 or N x 4 whole numbers of P x 3 points, not "
                             f"{corners.dtype} {corners.shape!r} of {vertices.shape!r}", parameter="faces")
        if corners.size and not 0 <= corners.min() <= corners.max() < len(vertices):
            raise InputError(f"geometry: Faces must be numbers below {len(vertices)}, not {corners.min()} to "
                             f"{corners.max()}", parameter="faces")
        vertices = vertices[corners]
    if vertices.ndim != 3 or vertices.shape[1:] not in ((3, 3), (4, 3)) or not len(vertices):
        raise InputError(f"geometry: Vertices must be N x 3 x 3 or N x 4 x 3, not {vertices.shape!r}",
                         parameter="geometry")
    if not np.isfinite(vertices).all():
        raise InputError("geometry: Vertices must be finite", parameter="geometry")
    return vertices[:, np.minimum([0, 1, 2, 3], vertices.shape[1] - 1)]
