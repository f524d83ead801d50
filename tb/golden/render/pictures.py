"""Small pictures of a scene."""

from golden.render.two_pass import RenderSettings, render
from golden.scene.camera import Camera

__all__ = ["SMALL", "looking", "picture"]

SMALL = {"width": 12, "height": 10, "samples": 1, "light_samples": 4, "rays": (16, 4), "max_edge": 100.0}


def picture(scene, camera=None, **settings):
    """A small picture, and its statistics."""
    return render(scene, camera=camera or scene.camera, settings=RenderSettings(**(SMALL | settings)))


def looking(eye, target, fov=10.0):
    """A camera of a narrow field of view."""
    return Camera(eye=eye, target=target, up=(0, 1, 0), fov=fov)
