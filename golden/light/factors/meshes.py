"""Scenes of vertices and meshes that a program has."""

import numpy as np

from golden.errors import InputError
from golden.scene.appearance import UNSPECIFIED
from golden.scene.facets import check_facets
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["geometry_scene"]


def geometry_scene(geometry, *, names=None, two_sided: bool = False) -> Scene:
    """The scene of facets, in their order.

    Parameters
    ----------
    geometry
        N x 3 x 3 triangles or N x 4 x 3 quadrilaterals (a triangle repeats its last vertex), counter-clockwise as seen
        from the front; an object with such ``triangles``, as `trimesh.Trimesh`; or a `Scene`, which stays as it is.
    names
        N names of surfaces. Default: one name for all.
    two_sided
        Whether backs radiate like fronts.

    Raises
    ------
    InputError
        Shapes do not match; a facet is not planar, not strictly convex, or has no area.
    """
    if isinstance(geometry, Scene):
        if names is not None or two_sided:
            raise InputError("view factors: Names and sides must be those of the scene")
        return geometry
    if not isinstance(two_sided, bool | np.bool_):
        raise InputError(f"view factors: Two sided must be True or False, not {two_sided!r}")
    try:
        vertices = np.asarray(getattr(geometry, "triangles", geometry), dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("view factors: Geometry must be a Scene, a mesh of triangles or N x 3 x 3 or N x 4 x 3 "
                         f"vertices, not {type(geometry).__name__}") from None
    if vertices.ndim != 3 or vertices.shape[1:] not in ((3, 3), (4, 3)) or not len(vertices):
        raise InputError(f"view factors: Vertices must be N x 3 x 3 or N x 4 x 3, not {vertices.shape!r}")
    if not np.isfinite(vertices).all():
        raise InputError("view factors: Vertices must be finite")
    vertices = vertices[:, np.minimum([0, 1, 2, 3], vertices.shape[1] - 1)]
    check_facets(vertices, "view factors")
    count = len(vertices)
    names = [UNSPECIFIED.name] * count if names is None else [str(name) for name in names]
    if len(names) != count:
        raise InputError(f"view factors: Names must be one for each of {count} facets, not {len(names)}")
    known = {name: number for number, name in enumerate(dict.fromkeys(names))}
    return Scene(name="facets", vertices=vertices, material=[known[name] for name in names],
                 materials=tuple(Material(name=name) for name in known), two_sided=np.full(count, two_sided))
