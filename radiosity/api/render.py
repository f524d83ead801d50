"""Pictures."""

from golden.base.errors import InputError
from golden.cast.default_camera import default_camera
from golden.light.photometry.sensors import Sensors
from golden.light.preview import Preview
from golden.render.two_pass import RenderResult, RenderSettings
from golden.render.two_pass import render as render_by
from golden.scene.camera import Camera
from golden.scene.scene import Scene

__all__ = ["render"]


def render(scene: Scene, *, camera: Camera | None = None, size: tuple[int, int] = (512, 512),
           sensors: Sensors | None = None, preview: Preview | None = None, jobs: int | None = None, seed: int = 0,
           progress: bool = False, **settings) -> RenderResult:
    """A picture: indirect light by radiosity, everything else by ray tracing.

    Parameters
    ----------
    scene
        The scene; it must have a light.
    camera
        The view. Default: the scene's, or one of all of it.
    size
        Width and height in pixels.
    sensors
        Points at which light is measured.
    preview
        Draws pictures between the steps of ``shooting``.
    jobs
        Threads; the picture does not depend on them. Default: one per processor that this process may use.
    seed
        Of all samples, at least 0.
    progress
        Shows progress bars for steps of more than two seconds.
    settings
        Others of `golden.render.two_pass.RenderSettings`: ``samples``, ``light_samples``, ``noise``, ``depth``,
        ``rays``, ``elements``, ``max_edge``, ``max_area``, ``solver``, ``shooting``, ``method``, ``cell``, ``memory``.

    Returns
    -------
    `RenderResult`: ``image`` (height x width x 3 float64 radiance), ``statistics``, ``save()`` and more.

    Raises
    ------
    InputError
        The scene has no light, or a parameter is out of range.
    """
    try:
        width, height = size
    except (TypeError, ValueError):
        raise InputError(f"Size must be a width and a height, not {size!r}", parameter="size") from None
    chosen = RenderSettings(width=width, height=height, jobs=jobs, seed=seed, **settings)
    return render_by(scene, camera=camera or default_camera(scene), settings=chosen, sensors=sensors,
                     preview=preview, progress=progress)
