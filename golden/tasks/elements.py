"""The elements of a scene whose form factors are computed."""

from golden.errors import InputError
from golden.scene.refine import refine
from golden.scene.scene import Scene

__all__ = ["MOST_ELEMENTS", "cut_into_elements"]

# Their form factors take 2 GiB.
MOST_ELEMENTS = 1 << 14


def cut_into_elements(scene: Scene, *, max_edge: float | None = None, max_area: float | None = None) -> Scene:
    """The scene's elements as a scene; the patches themselves if no limit is given.

    Raises
    ------
    InputError
        There are more than `MOST_ELEMENTS`.
    """
    if max_edge is not None or max_area is not None:
        scene = refine(scene, max_edge=max_edge, max_area=max_area).scene
    if len(scene) > MOST_ELEMENTS:
        raise InputError(f"form factors: there may be {MOST_ELEMENTS} elements at most, not {len(scene)}")
    return scene
