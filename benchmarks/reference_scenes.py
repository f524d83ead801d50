"""The scenes of `radiosity bench references`: rooms, windows, lamps and bodies of many kinds."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

from golden.scene.appearance import from_srgb
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import furniture
from golden.scene.builtin.shapes import FACES, box, framed, placed
from golden.scene.camera import Camera
from golden.scene.lights import Cone, PointLight
from golden.scene.luminaires.luminaire import Luminaire
from golden.scene.material import Material
from golden.scene.open import open_scene
from golden.scene.scene import Scene
from golden.scene.sky.daylight import Daylight
from golden.scene.tessellate import sphere

__all__ = ["SCENES", "ReferenceScene", "level", "shell"]

PLASTER = Material(name="plaster", diffuse=(0.75, 0.73, 0.70))
CEILING = Material(name="ceiling", diffuse=(0.80, 0.80, 0.80))
WOOD = Material(name="wood", diffuse=(0.45, 0.32, 0.20))
RED = Material(name="red", diffuse=(0.60, 0.12, 0.10))
BLUE = Material(name="blue", diffuse=(0.12, 0.20, 0.55))
GREY = Material(name="grey", diffuse=(0.50, 0.50, 0.50))
LAMP = Material(name="lamp", diffuse=(0.50, 0.50, 0.50), emission=(12.0, 11.0, 9.0))
PANE = Material(name="pane", transparent=(0.95, 0.97, 0.96), thin=True)
MIRROR = Material(name="mirror", specular=(0.85, 0.85, 0.85))
BALL = Material(name="glass ball", transparent=(1.0, 1.0, 1.0))
SUN, EFFICACY = (215.0, 38.0), 179.0
# Colours of an atlas' four quarters, 0 to 255: upper left, upper right, lower left, lower right.
ATLAS = ((200, 60, 50), (225, 222, 215), (60, 90, 190), (150, 120, 80))
# Candela of an office luminaire at 0, 10 ... 90 degrees.
BATWING = (900, 930, 1000, 1080, 1100, 980, 640, 260, 60, 0)


@dataclass(frozen=True, kw_only=True)
class ReferenceScene:
    """A scene, and what the path tracer is given where it differs.

    Parameters
    ----------
    make
        The scene as it is rendered.
    traced
        The scene as it is traced. Default: the same.
    balls
        Exact spheres, centre and radius, which replace the patches of a material with this name.
    origin, scale
        The traced scene is moved by minus ``origin`` and scaled: single precision resolves most near the origin.
    """

    make: Callable[[], Scene]
    traced: Callable[[], Scene] | None = None
    balls: dict[str, tuple[tuple[float, float, float], float]] = field(default_factory=dict)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    scale: float = 1.0


def level(low, high, z):
    """A horizontal rectangle that faces down."""
    return [(low[0], low[1], z), (low[0], high[1], z), (high[0], high[1], z), (high[0], low[1], z)]


def shell(builder, size, *, window=None, pane=None):
    """A closed room; ``window``: the distance of an opening from the edges of the wall at y = 0, filled by ``pane``."""
    colours = dict(zip(FACES, (RED, BLUE, PLASTER, PLASTER, WOOD, CEILING), strict=True))
    for name, patch in zip(FACES, box((0, 0, 0), size)[:, ::-1], strict=True):
        if name == "-y" and window is not None:
            parts = framed(patch, border=window)
            builder.add(parts[:4], colours[name], two_sided=True)
            if pane is not None:
                builder.add(parts[4], pane, two_sided=True)
        else:
            builder.add(patch, colours[name], two_sided=window is not None)


def _lit_room(builder):
    """A room of 4 x 5 x 2.8 with a lamp flush below its ceiling."""
    shell(builder, (4, 5, 2.8))
    builder.add(level((1.5, 2.0), (2.5, 3.0), 2.79), LAMP)


def _blocks(builder):
    builder.add(placed(box((-0.4, -0.4, 0), (0.4, 0.4, 1.1), omit=("-z",)), at=(2.8, 3.4, 0), turn=25), PLASTER)
    builder.add(placed(box((-0.4, -0.4, 0), (0.4, 0.4, 0.6), omit=("-z",)), at=(1.2, 3.0, 0), turn=-15), GREY)


INSIDE = Camera(eye=(0.4, 0.4, 1.5), target=(2.6, 3.6, 1.1), fov=62)
FROM_WINDOW = Camera(eye=(3.6, 0.5, 1.6), target=(1.4, 4.0, 0.9), fov=66)


def _closed_room():
    builder = SceneBuilder("closed room")
    _lit_room(builder)
    _blocks(builder)
    return builder.build(camera=INSIDE)


def _panel(gap):
    builder = SceneBuilder("panel")
    shell(builder, (4, 4, 2.6))
    builder.add(level((1.4, 1.4), (2.6, 2.6), 2.6 - gap), LAMP, two_sided=True)
    builder.add(box((2.4, 2.2, 0), (3.2, 3.0, 0.8), omit=("-z",)), GREY)
    return builder.build(camera=Camera(eye=(0.4, 0.4, 1.2), target=(2.6, 2.6, 1.5), fov=75))


def _windows(sky, **daylight):
    builder = SceneBuilder("window")
    shell(builder, (4, 5, 2.8), window=0.7, pane=PANE)
    _blocks(builder)
    return Daylight(sky=sky, **daylight).scene(builder.build(camera=FROM_WINDOW), EFFICACY)


def _terrace():
    builder = SceneBuilder("terrace")
    builder.add(level((-6, -6), (6, 6), 0)[::-1], GREY)
    builder.add(box((-1.5, 1, 0), (1.5, 2, 2.4), omit=("-z",)), PLASTER)
    builder.add(placed(box((-0.5, -0.5, 0), (0.5, 0.5, 1), omit=("-z",)), at=(1.6, -0.6, 0), turn=30), RED)
    camera = Camera(eye=(-3.5, -6, 3), target=(0.2, 0.4, 0.8), fov=42)
    return Daylight(sky="cie-clear", sun=SUN).scene(builder.build(camera=camera), EFFICACY)


def _mirror():
    builder = SceneBuilder("mirror")
    _lit_room(builder)
    _blocks(builder)
    builder.add([(3.99, 1.2, 0.6), (3.99, 3.8, 0.6), (3.99, 3.8, 2.2), (3.99, 1.2, 2.2)][::-1], MIRROR)
    return builder.build(camera=INSIDE)


def _partition():
    builder = SceneBuilder("partition")
    _lit_room(builder)
    _blocks(builder)
    builder.add([(0.5, 2.2, 0), (3.5, 2.2, 0), (3.5, 2.2, 2.0), (0.5, 2.2, 2.0)], PANE, two_sided=True)
    return builder.build(camera=INSIDE)


def _glass_ball():
    builder = SceneBuilder("glass ball")
    _lit_room(builder)
    builder.add(sphere((2.2, 3.0, 0.55), 0.5, segments=64), BALL, smooth=True)
    return builder.build(camera=INSIDE)


def _painted_room(colours):
    """The room of the atlas scene with the colours of floor, walls, long walls and ceiling."""
    builder = SceneBuilder("atlas")
    red, white, blue, brown = (Material(name=name, diffuse=tuple(colour)) for name, colour in zip(
        ("red", "white", "blue", "brown"), colours, strict=True))
    for patch, colour in zip(box((0, 0, 0), (4, 5, 2.8))[:, ::-1], (blue, blue, white, white, red, white), strict=True):
        builder.add(patch, colour)
    builder.add(box((2.2, 3.0, 0), (3.2, 3.8, 0.9), omit=("-z",)), brown)
    return builder


def _painted():
    builder = _painted_room(from_srgb(np.array(ATLAS) / 255))
    # Faces of an OBJ file are two-sided.
    builder.add(level((1.5, 2.0), (2.5, 3.0), 2.79), LAMP, two_sided=True)
    return builder.build(camera=INSIDE)


def _atlas():
    """The same from an OBJ file: one picture, and faces that show a quarter of it each."""
    plain = _painted_room(np.arange(1, 5)[:, None] * [0.1, 0.1, 0.1]).build()
    quarters = ((0.05, 0.55), (0.55, 0.55), (0.05, 0.05), (0.55, 0.05))
    lines = ["mtllib atlas.mtl", "usemtl painted"]
    for patch, number in zip(plain.vertices, plain.material, strict=True):
        name = plain.materials[number].name
        u, v = quarters[("red", "white", "blue", "brown").index(name)]
        lines += [f"v {x} {y} {z}" for x, y, z in patch.tolist()]
        lines += [f"vt {u + 0.4 * x} {v + 0.4 * y}" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        lines.append("f -4/-4 -3/-3 -2/-2 -1/-1")
    lines += ["usemtl lamp", *(f"v {x} {y} {z}" for x, y, z in level((1.5, 2.0), (2.5, 3.0), 2.79)), "f -4 -3 -2 -1"]
    picture = np.repeat(np.repeat(np.array(ATLAS, dtype=np.uint8).reshape(2, 2, 3), 64, axis=0), 64, axis=1)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "atlas.obj"
        path.write_text("\n".join(lines) + "\n")
        path.with_suffix(".mtl").write_text("newmtl painted\nKd 1 1 1\nmap_Kd atlas.png\n"
                                            "newmtl lamp\nKd 0.5 0.5 0.5\nKe 12 11 9\n")
        Image.fromarray(picture).save(path.with_suffix(".png"))
        scene = open_scene(str(path), zenith=(0.0, 0.0, 1.0))
    return replace(scene, camera=INSIDE)


def _lights():
    builder = SceneBuilder("lights")
    shell(builder, (4, 5, 2.8))
    _blocks(builder)
    for x, colour in ((0.7, (14, 4, 3)), (1.9, (4, 13, 5)), (3.1, (3, 5, 15))):
        builder.add(level((x, 1.0), (x + 0.3, 4.0), 2.78), Material(name=f"lamp {x}", emission=colour))
    builder.add(box((0.02, 2.0, 1.6), (0.1, 2.4, 1.9)), Material(name="wall lamp", emission=(10, 9, 6)))
    return builder.build(camera=INSIDE, lights=(
        PointLight(position=(2.0, 1.2, 1.8), intensity=(1.5, 1.4, 1.2)),
        PointLight(position=(3.0, 1.5, 2.6), intensity=(6.0, 6.0, 6.0),
                   cone=Cone(direction=(-0.3, 0.6, -1), inner=15, outer=30))))


def _office():
    builder = SceneBuilder("office")
    shell(builder, (9, 7, 2.8))
    for x in 2.0, 4.5, 7.0:
        for y in 2.2, 4.8:
            furniture.table(builder, width=1.6, depth=0.8, at=(x, y, 0))
            builder.add(box((x - 0.9, y + 0.45, 0), (x + 0.9, y + 0.5, 1.3), omit=("-z",)), BLUE)
    scene = builder.build(camera=Camera(eye=(0.5, 0.5, 1.7), target=(5.5, 4.2, 1.0), fov=62))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "office.ies"
        path.write_text("\n".join([
            "IESNA:LM-63-2002", "TILT=NONE", f"1 -1 1 {len(BATWING)} 1 1 2 0.6 0.6 0", "1 1 30",
            " ".join(str(10 * step) for step in range(len(BATWING))), "0", " ".join(map(str, BATWING))]) + "\n")
        for x in 1.5, 4.5, 7.5:
            for y in 2.0, 5.0:
                scene = Luminaire(path=path, place=(x, y, 2.75)).scene(scene, EFFICACY)
    return scene


def _sunk():
    builder = SceneBuilder("sunk")
    _lit_room(builder)
    tilted = placed(box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), at=(2.7, 3.2, 0.25), turn=30, axis=(0.3, 0.2, 1.0))
    builder.add(tilted, PLASTER)
    builder.add(box((0.9, 2.4, -0.3), (1.6, 3.4, 0.5)), GREY)
    builder.add(placed(box((-0.3, -0.3, -0.2), (0.3, 0.3, 0.9)), at=(1.5, 3.2, 0), turn=40), BLUE)
    return builder.build(camera=INSIDE)


def _contact():
    builder = SceneBuilder("contact")
    _lit_room(builder)
    builder.add(box((2.2, 3.0, 0), (3.2, 4.0, 0.7)), PLASTER)
    builder.add(placed(box((-0.3, -0.3, 0), (0.3, 0.3, 0.6)), at=(2.7, 3.5, 0.7), turn=35), RED)
    builder.add(box((1.4, 3.0, 0), (2.2, 3.6, 1.2)), GREY)
    builder.add(box((0, 3.6, 0), (0.5, 5, 2.0)), PLASTER)
    return builder.build(camera=INSIDE)


SCENES: dict[str, ReferenceScene] = {
    "closed room": ReferenceScene(make=_closed_room),
    **{f"panel {name} below the ceiling": ReferenceScene(make=partial(_panel, gap), origin=(2, 2, 2.6 - gap), scale=1e3)
       for name, gap in (("1 mm", 0.001), ("1 cm", 0.01), ("10 cm", 0.1))},
    "pane, overcast sky": ReferenceScene(make=partial(_windows, "cie-overcast")),
    "pane, clear sky and sun": ReferenceScene(make=partial(_windows, "cie-clear", sun=SUN)),
    "terrace, clear sky and sun": ReferenceScene(make=_terrace),
    "mirror": ReferenceScene(make=_mirror),
    "glass partition": ReferenceScene(make=_partition),
    "glass ball": ReferenceScene(make=_glass_ball, balls={BALL.name: ((2.2, 3.0, 0.55), 0.5)}),
    "atlas of colours": ReferenceScene(make=_atlas, traced=_painted, origin=(2.0, 2.5, 2.79), scale=1e3),
    "several lights": ReferenceScene(make=_lights),
    "office with luminaires": ReferenceScene(make=_office),
    "bodies sunk into the floor": ReferenceScene(make=_sunk),
    "bodies in contact": ReferenceScene(make=_contact),
}
"""The scenes by name."""
