"""Cubes as the furnace, of other materials."""

from dataclasses import replace

import numpy as np

from golden.scene.builtin.furnace import furnace
from golden.scene.material import Material

__all__ = ["furnace_of", "lit_from_above"]


def furnace_of(size, *, diffuse):
    """The furnace whose faces reflect another share: they shine with 1 / (1 - diffuse)."""
    scene = furnace(size)
    return replace(scene, materials=(replace(scene.materials[0], diffuse=(diffuse,) * 3),))


def lit_from_above(size):
    """Its ceiling alone emits, and is black; floor and walls reflect half of the light."""
    scene = furnace(size)
    light = Material(name="emitter", emission=(1.0,) * 3)
    return replace(scene, material=np.where(scene.normals[:, 2] == -1, 1, 0),
                   materials=(replace(scene.materials[0], emission=(0.0,) * 3), light))
