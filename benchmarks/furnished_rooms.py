"""Furnished rooms for `radiosity bench references`: bodies that stand on floors and hang close to walls."""

from benchmarks.reference_scenes import BLUE, EFFICACY, GREY, LAMP, PLASTER, RED, WOOD, ReferenceScene, level, shell
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import furniture
from golden.scene.builtin.shapes import box, placed
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.sky.daylight import Daylight

__all__ = ["ROOMS"]

WHITE = Material(name="white", diffuse=(0.80, 0.78, 0.75))


def _bodies(builder, *parts):
    """Boxes that stand on something: lower corner, upper corner, material."""
    for lower, upper, material in parts:
        builder.add(box(lower, upper, omit=("-z",)), material)


def _office():
    builder = SceneBuilder("furnished office")
    shell(builder, (6, 5, 2.8))
    for x in 1.2, 3.0, 4.8:
        builder.add(level((x - 0.6, 2.4), (x + 0.6, 2.7), 2.77), LAMP)
    for x in 1.5, 4.4:
        furniture.table(builder, width=1.6, depth=0.8, at=(x, 3.4, 0))
        furniture.chair(builder, at=(x, 2.8, 0), turn=10)
        builder.add(placed(box((-0.25, -0.1, 0), (0.25, 0.1, 0.4), omit=("-z",)), at=(x, 3.5, 0.74), turn=20), GREY)
    furniture.bookshelf(builder, books=(5, 4, 6, 3), seed=1, at=(3.0, 5, 0), turn=180)
    builder.add([(3.0, 2.2, 0), (3.0, 4.2, 0), (3.0, 4.2, 1.4), (3.0, 2.2, 1.4)], BLUE, two_sided=True)
    return builder.build(camera=Camera(eye=(0.4, 0.4, 1.7), target=(3.6, 3.8, 0.2), fov=54))


def _bedroom():
    builder = SceneBuilder("furnished bedroom")
    shell(builder, (4, 5, 2.8), window=0.8)
    _bodies(builder, ((1.0, 2.8, 0), (2.8, 4.8, 0.45), WHITE), ((1.0, 4.8, 0), (2.8, 4.9, 1.0), WOOD),
            ((0.3, 4.2, 0), (0.8, 4.7, 0.5), WOOD), ((3.3, 2.0, 0), (4.0, 4.0, 2.1), PLASTER))
    builder.add(placed(box((-0.7, -0.5, 0), (0.7, 0.5, 0.02), omit=("-z",)), at=(1.6, 1.7, 0), turn=15), RED)
    return Daylight(sky="cie-overcast").scene(
        builder.build(camera=Camera(eye=(3.6, 0.5, 1.6), target=(1.5, 3.6, 0.5), fov=66)), EFFICACY)


def _kitchen():
    builder = SceneBuilder("furnished kitchen")
    shell(builder, (4, 3.5, 2.6))
    builder.add(level((1.4, 1.2), (2.6, 1.6), 2.57), LAMP)
    _bodies(builder, ((0, 2.9, 0), (3.2, 3.5, 0.9), WHITE), ((3.3, 2.8, 0), (4, 3.5, 1.9), GREY))
    builder.add(box((0.2, 3.15, 1.45), (3.0, 3.5, 2.15)), WOOD)
    builder.add(level((0.6, 3.2), (2.6, 3.25), 1.44), LAMP)
    furniture.table(builder, width=1.2, depth=0.8, at=(1.5, 1.4, 0), turn=8)
    for x in 1.2, 1.8:
        furniture.chair(builder, at=(x, 0.9, 0), turn=5)
    return builder.build(camera=Camera(eye=(3.6, 0.3, 1.7), target=(1.4, 3.0, 0.8), fov=66))


def _stairs():
    builder = SceneBuilder("furnished stairs")
    shell(builder, (5, 4, 3), window=0.7)
    _bodies(builder, *(((0.8 + 0.28 * k, 2.4, 0.17 * k), (2.8, 3.6, 0.17 * (k + 1)), WOOD) for k in range(6)),
            ((3.6, 2.0, 0), (3.85, 2.25, 3), PLASTER))
    return Daylight(sky="cie-overcast").scene(
        builder.build(camera=Camera(eye=(4.4, 0.5, 1.7), target=(1.9, 2.9, 0.6), fov=66)), EFFICACY)


def _living_room():
    builder = SceneBuilder("furnished living room")
    shell(builder, (5, 5, 2.7), window=0.6)
    _bodies(builder, ((1.2, 3.9, 0), (3.4, 4.7, 0.42), BLUE), ((1.2, 4.7, 0), (3.4, 4.95, 0.85), BLUE),
            ((1.0, 3.9, 0), (1.2, 4.95, 0.6), BLUE), ((3.4, 3.9, 0), (3.6, 4.95, 0.6), BLUE),
            ((1.4, 2.0, 0), (3.2, 3.4, 0.01), RED), ((4.55, 1.5, 0), (5, 3.0, 0.5), WOOD))
    for z in 1.2, 1.6:
        builder.add(box((4.75, 1.4, z), (5, 3.2, z + 0.03)), WOOD)
    furniture.table(builder, width=1.0, depth=0.6, at=(2.3, 2.7, 0.01))
    builder.add(level((0.4, 4.3), (0.7, 4.6), 1.5), LAMP)
    return Daylight(sky="cie-overcast").scene(
        builder.build(camera=Camera(eye=(0.6, 0.6, 1.6), target=(3.0, 3.8, 0.5), fov=66)), EFFICACY)


ROOMS = {f"furnished {name}": ReferenceScene(make=make) for name, make in (
    ("office", _office), ("bedroom", _bedroom), ("kitchen", _kitchen), ("stairs", _stairs),
    ("living room", _living_room))}
"""The rooms by name."""
