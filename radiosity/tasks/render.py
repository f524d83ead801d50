"""An image of a scene, written in the requested format."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from golden.base.input_warnings import warn
from golden.base.output import beginning_with, check_inputs_stay, check_named_once, check_outputs, whole_file
from golden.base.summary import summary
from golden.cast.default_camera import default_camera
from golden.light.image import false_colour, write_png
from golden.light.preview import Preview
from golden.light.tone import check_display
from golden.render.two_pass import RenderResult, RenderSettings, render
from golden.scene.lights import PointLight
from golden.scene.luminaires.luminaire import Luminaire
from golden.scene.open import open_scene
from golden.scene.scene import Scene
from golden.scene.sky.daylight import Daylight
from golden.scene.zenith import warn_of_upright_floors, zenith_line
from radiosity.tasks.photometry import Photometry

__all__ = ["RenderFiles", "View", "render_scene"]

# A scene longer than this, in metres, may have another unit.
LONGEST = 1000


@dataclass(frozen=True, kw_only=True)
class View:
    """The parts of the camera and the background that replace the scene's own.

    Parameters
    ----------
    eye, target, up, fov
        See `golden.scene.camera.Camera`.
    zenith
        The scene's up, for skies, luminaires and a view of all of the scene, see `open_scene`.
    sky
        Radiance from outside the scene.
    daylight
        Sky and sun instead of it, or None.
    luminaires
        Lights that are added.
    """

    eye: tuple[float, ...] | None = None
    target: tuple[float, ...] | None = None
    up: tuple[float, ...] | None = None
    fov: float | None = None
    zenith: tuple[float, ...] | None = None
    sky: tuple[float, ...] | None = None
    daylight: Daylight | None = None
    luminaires: tuple[Luminaire, ...] = ()

    def scene(self, name: str, efficacy: float) -> Scene:
        """The scene with this background and these lights, for ``efficacy`` in lm/W.

        Warns
        -----
        InputWarning
            Floors stand upright, or a scene with point lights is longer than a kilometre.
        """
        opened = open_scene(name, zenith=self.zenith)
        if self.zenith is None:
            warn_of_upright_floors(opened)
        if self.sky is not None:
            opened = replace(opened, background=self.sky)
        for light in (self.daylight, *self.luminaires):
            opened = opened if light is None else light.scene(opened, efficacy)
        if opened.size > LONGEST and any(isinstance(light, PointLight) for light in opened.lights):
            warn(f"scene {opened.name!r}: it is {opened.size:g} long, and a length counts as a metre for "
                 f"{'luminaires' if self.luminaires else 'its point lights'}; in another unit they are too dark")
        return opened

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read beside the scene."""
        return tuple(light.path for light in self.luminaires)

    def camera(self, scene: Scene):
        """The scene's camera, or one of all of it, with the parts that are given."""
        given = {name: getattr(self, name) for name in ("eye", "target", "up", "fov")}
        return replace(default_camera(scene), **{name: value for name, value in given.items() if value is not None})


@dataclass(frozen=True, kw_only=True)
class RenderFiles:
    """The files of an image.

    Parameters
    ----------
    images
        Paths ending in .png or .exr.
    photometry
        What is measured, and its files.
    stats
        For the statistics. (.json)
    heatmap
        The beginning of the names of two pictures: patch tests and cell steps of each pixel.
    preview
        Draws pictures while elements shoot.
    exposure, tone, gamma, bits
        See `golden.light.tone.tone_map`, for every .png.

    Raises
    ------
    InputError
        A file cannot be written, or is named twice; exposure or gamma is out of range.
    """

    images: tuple[Path, ...]
    photometry: Photometry = field(default_factory=Photometry)
    stats: Path | None = None
    heatmap: Path | None = None
    preview: Preview | None = None
    exposure: float | None = None
    tone: str = "reinhard"
    gamma: float | None = None
    bits: int = 8

    def __post_init__(self):
        check_outputs(*self.images, suffixes=(".png", ".exr"))
        check_outputs(*self.heatmaps, suffixes=(".png",))
        check_outputs(self.stats, suffixes=(".json",))
        check_named_once(*self.outputs)
        check_display(self.exposure, self.gamma)

    @property
    def outputs(self) -> tuple[Path | None, ...]:
        """All files that are written."""
        preview = self.preview and self.preview.path
        return *self.images, *self.heatmaps, self.stats, preview, *self.photometry.outputs

    @property
    def heatmaps(self) -> tuple[Path, ...]:
        """The two pictures, or none."""
        return beginning_with(self.heatmap, "-tests.png", "-steps.png")

    def write(self, result: RenderResult, stats: dict) -> None:
        """Write all of them."""
        for path in self.images:
            result.save(path, exposure=self.exposure, curve=self.tone, gamma=self.gamma, bits=self.bits,
                        efficacy=self.photometry.efficacy)
        values = (result.tests, result.steps)
        for path, counts, what in zip(self.heatmaps, values, ("patch tests", "cell steps"), strict=False):
            write_png(path, false_colour(counts, f"{what} per pixel"))
        if self.stats:
            with whole_file(self.stats) as part:
                part.write_text(json.dumps(stats, indent=1) + "\n")


def render_scene(scene: str, view: View, settings: RenderSettings, files: RenderFiles, *, method: str,
                 caster: Callable, workers=None, progress: bool = False,
                 estimate: Callable[[int, float], None] | None = None) -> tuple[dict, str]:
    """Render a scene and write its files.

    Parameters
    ----------
    scene
        A name as `open_scene` takes it.
    view, settings, files
        What to show, how to render, where to write.
    method
        What the statistics call the caster of frusta.
    caster
        Gives, for the opened scene, a context manager of a caster of frusta with ``counts()``, ``summary()`` and
        ``ray_kinds``, the kinds of rays that it casts, and ``specular_rays``, how many of others; of None for that of
        the settings.
    workers, progress, estimate
        See `golden.render.two_pass.render`.

    Returns
    -------
    The statistics, and as text.

    Raises
    ------
    InputError
        See `golden.render.two_pass.render`.
    """
    opened = view.scene(scene, files.photometry.efficacy)
    inputs = (scene, *opened.files, *view.files, *filter(None, [files.photometry.sensors]))
    check_inputs_stay(*inputs, outputs=files.outputs)
    sensors = files.photometry.read()
    camera = view.camera(opened)
    with caster(opened) as cast:
        result = render(opened, camera=camera, settings=settings, frusta=cast, workers=workers, progress=progress,
                        sensors=sensors, with_received=files.photometry.false_colour is not None,
                        preview=files.preview, estimate=estimate)
    zenith = zenith_line(scene, opened, is_given=view.zenith is not None,
                         facing=None if sensors is None else sensors.normal)
    stats, text = {**result.stats, "zenith": list(map(float, opened.up))}, f"{summary(result.stats)}\n{zenith}"
    if cast is not None:
        rays = {kind: counts["rays"] for kind, counts in stats["rays"].items()}
        share = (sum(rays.get(kind, 0) for kind in cast.ray_kinds) + cast.specular_rays) / max(1, sum(rays.values()))
        stats = {**stats, "settings": {**stats["settings"], "method": method},
                 method: {**cast.counts(), "share": share}}
        text += f"\n\n{cast.summary()}\n{share:.1%} of all rays by method {method}"
    figures, lines = files.photometry.write(opened, result, sensors, exposure=files.exposure)
    if lines:
        stats, text = {**stats, **figures}, f"{text}\n\n{lines}"
    files.write(result, stats)
    return stats, text
