"""Frustum records as fields of a stimulus."""

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.frustum.bundle import Bundle
from golden.engine.frustum.shadow_record import ShadowRecord
from golden.engine.lib.fixed import signed, unsigned
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.stimulus.block import FLAG, Arrays, Field
from golden.scene.camera import Camera

__all__ = ["SOURCE", "frustum_arrays", "frustum_fields", "frustum_record", "random_frustum", "random_hemisphere",
           "random_screen"]

# Surface on which a frustum's rays start.
SOURCE = 3
HEMISPHERE, SCREEN = (64, 16), (60, 45)
# Of a shadow frustum alone.
_LISTED = ["offset", "end"]
_SIZES = ("columns", "rows", "column_bits", "row_bits", "source")


def random_hemisphere(random: np.random.Generator, config: Config, size=HEMISPHERE) -> FrustumRecord:
    """A hemisphere around a random normal; ``size``: azimuths and polars."""
    return hemisphere_record(Hemisphere(*size), _unit(config), random.uniform(0.3, 0.7, 3),
                             random.normal(size=3), source=SOURCE)


def random_screen(random: np.random.Generator, config: Config, size=SCREEN) -> FrustumRecord:
    """A screen of a random camera; ``size`` in pixels."""
    eye = random.uniform(0.3, 0.7, 3)
    camera = Camera(eye=tuple(eye), target=tuple(eye + random.normal(size=3)), up=tuple(random.normal(size=3)),
                    fov=float(random.choice([20, 60, 100])))
    return screen_record(Screen(camera=camera, width=size[0], height=size[1]), _unit(config))


def random_frustum(random: np.random.Generator, config: Config) -> FrustumRecord:
    """A hemisphere or a screen."""
    return random.choice([random_hemisphere, random_screen])(random, config)


def frustum_fields(config: Config) -> list[Field]:
    """Fields of `frustum_arrays`."""
    numbers = config.numbers
    return [Field(f"frustum_{name}", form, about, constant=True) for name, form, about in (
        ("is_screen", FLAG, "screen or hemisphere"),
        ("origin", numbers.scene, "G coordinates"),
        ("matrix", numbers.direction, "G to R"),
        ("to_global", numbers.direction, "directions of grid rays to G"),
        ("z_scale", unsigned(1, numbers.direction_fraction), "R coordinate of depth 1"),
        ("half_angles", None, "slopes of a screen at x = 1 and y = 1"),
        ("columns", unsigned(17, 0), "azimuths or pixels across"),
        ("rows", unsigned(17, 0), "polar angles or pixels down"),
        ("column_bits", unsigned(5, 0), "binary logarithm of the columns of the full grid"),
        ("row_bits", unsigned(5, 0), "binary logarithm of the rows of the full grid"),
        ("column_table", numbers.direction, "(cos, sin) of each azimuth, or x of each column"),
        ("row_table", numbers.direction, "(sin, cos) of each polar angle, or y of each row"),
        ("source", signed(31, 0), "the surface that the rays start on and never hit, or -1"))]


def frustum_arrays(record: FrustumRecord) -> Arrays:
    """Arrays of a record."""
    names = [field.name.removeprefix("frustum_") for field in frustum_fields(Config())]
    names += _LISTED if record.bundle == Bundle.SHADOW else []
    return {f"frustum_{name}": np.asarray(getattr(record, name), dtype=None if name == "half_angles" else np.int64)
            for name in names}


def frustum_record(given: Arrays, config: Config) -> FrustumRecord:
    """The record of its arrays."""
    part = {name.removeprefix("frustum_"): value for name, value in given.items() if name.startswith("frustum_")}
    part |= {name: int(part[name]) for name in (*_SIZES, "z_scale")}
    part |= {"is_screen": bool(part["is_screen"]), "half_angles": tuple(part["half_angles"].tolist())}
    return (ShadowRecord if _LISTED[0] in part else FrustumRecord)(numbers=config.numbers, **part)


def _unit(config):
    return GCoordinates(corner=np.zeros(3), scale=1.0, numbers=config.numbers, bounds=np.array([[0.1] * 3, [0.9] * 3]))
