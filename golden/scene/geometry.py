"""Scenes, or vertices and meshes that a program has."""

from golden.base.errors import InputError
from golden.scene.scene import Scene

__all__ = ["geometry_scene"]


def geometry_scene(geometry, *, names=None, two_sided: bool = False) -> Scene:
    """The scene of facets, in their order.

    Parameters
    ----------
    geometry
        What `Scene.from_arrays` takes as vertices; an object with such ``triangles``, as `trimesh.Trimesh`; or a
        `Scene`, which stays as it is.
    names, two_sided
        See `Scene.from_arrays`.

    Raises
    ------
    InputError
        Shapes do not match; a facet is not planar, not strictly convex, or has no area.
    """
    if not isinstance(geometry, Scene):
        return Scene.from_arrays(geometry, names=names, two_sided=two_sided)
    if names is not None or two_sided:
        raise InputError("geometry: Names and sides must be those of the scene",
                         parameter="two_sided" if names is None else "names")
    return geometry
