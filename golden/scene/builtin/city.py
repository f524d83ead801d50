"""A city for view factors: blocks with courtyards, towers, churches and lawns between streets, all in small facets."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.lights import PointLight
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["CELL", "STOREY", "city"]

CELL, STOREY = 4.0, 3.5
"""Edges of a facet in metres, along the ground and upwards."""

PLOT, STREET = 10, 4
"""Cells along the edge of a plot, and across a street with its pavements."""

RISE = 3.0
"""Metres by which a roof rises over a cell."""

SEED = 50

ASPHALT = Material(name="asphalt", diffuse=(0.10, 0.10, 0.11))
PAVEMENT = Material(name="pavement", diffuse=(0.42, 0.41, 0.39))
LAWN = Material(name="lawn", diffuse=(0.13, 0.24, 0.07))
TILES = Material(name="roof tiles", diffuse=(0.45, 0.15, 0.08))
SLATE = Material(name="slate", diffuse=(0.15, 0.16, 0.19))
GRAVEL = Material(name="flat roof", diffuse=(0.34, 0.33, 0.32))
PLASTERS = tuple(Material(name=f"{name} plaster", diffuse=colour) for name, colour in (
    ("white", (0.74, 0.72, 0.66)), ("ochre", (0.68, 0.50, 0.26)), ("pink", (0.66, 0.42, 0.34)),
    ("grey", (0.48, 0.49, 0.48))))
STONE = Material(name="sandstone", diffuse=(0.58, 0.50, 0.38))
GLASS = Material(name="glass front", diffuse=(0.16, 0.25, 0.31))
CONCRETE = Material(name="concrete", diffuse=(0.52, 0.51, 0.49))


@dataclass
class _Cells:
    """Square cells of the ground: storeys, whether the top is a roof that rises, and the materials of both."""

    storeys: np.ndarray
    pitched: np.ndarray
    rise: np.ndarray
    top: np.ndarray
    wall: np.ndarray

    @classmethod
    def of(cls, count: int, top: Material) -> "_Cells":
        """Flat ground of ``count`` x ``count`` cells; the rise is that of their corners."""
        shape = count, count
        return cls(storeys=np.zeros(shape, dtype=int), pitched=np.zeros(shape, dtype=bool),
                   rise=np.zeros((count + 1, count + 1)), top=np.full(shape, top, dtype=object),
                   wall=np.full(shape, PAVEMENT, dtype=object))

    def build(self, where, storeys: int, wall: Material, top: Material) -> None:
        """Raises cells to a height."""
        self.storeys[where], self.wall[where], self.top[where] = storeys, wall, top


def _courtyard(random, tall) -> _Cells:
    """Four wings with a hipped roof around a court."""
    cells = _Cells.of(PLOT, LAWN)
    ring = np.ones((PLOT, PLOT), dtype=bool)
    ring[2:-2, 2:-2] = False
    cells.build(ring, 4 + int(random.integers(3)) + tall // 3, PLASTERS[random.integers(len(PLASTERS))], TILES)
    cells.pitched = ring
    edge = np.minimum(np.arange(PLOT + 1), np.arange(PLOT, -1, -1))
    cells.rise = RISE * (np.minimum.outer(edge, edge) == 1)
    return cells


def _tower(random, tall) -> _Cells:
    """A tower of two steps on a base."""
    cells = _Cells.of(PLOT, PAVEMENT)
    cells.build(np.s_[:, :], 2, CONCRETE, GRAVEL)
    height = 10 + int(random.integers(6)) + tall
    front = (GLASS, CONCRETE)[random.integers(2)]
    cells.build(np.s_[2:8, 2:8], height, front, GRAVEL)
    cells.build(np.s_[3:7, 3:7], height + 4, front, GRAVEL)
    return cells


def _slabs(random, tall) -> _Cells:
    """Two long houses with flat roofs, and a low one across."""
    cells = _Cells.of(PLOT, LAWN)
    wall = PLASTERS[random.integers(len(PLASTERS))]
    for first in 0, 7:
        cells.build(np.s_[first:first + 3, :], 6 + int(random.integers(3)) + tall // 2, wall, GRAVEL)
    cells.build(np.s_[3:7, 8:], 2, CONCRETE, GRAVEL)
    return cells


def _church(random, tall) -> _Cells:
    """A nave with gables and a tower with a spire, on a lawn."""
    cells = _Cells.of(PLOT, LAWN)
    cells.build(np.s_[1:9, 3:7], 3, STONE, SLATE)
    cells.build(np.s_[0:2, 1:3], 8, STONE, SLATE)
    cells.pitched[1:9, 3:7] = cells.pitched[0:2, 1:3] = True
    cells.rise[1:10, 3:8] = 1.5 * RISE * np.array([0, 1, 2, 1, 0])
    cells.rise[1, 2] = 4 * RISE
    return cells


def _lay_out(size: int) -> _Cells:
    """All cells of ``size`` x ``size`` plots, with streets around each."""
    period = PLOT + STREET
    town = _Cells.of(size * period + STREET, PAVEMENT)
    edge = np.arange(len(town.storeys)) % period
    road = (edge > 0) & (edge < STREET - 1)
    town.top[road[:, None] | road] = ASPHALT
    kinds, shares = (_courtyard, _tower, _slabs, _church), np.array([0.5, 0.2, 0.2, 0.1])
    for i in range(size):
        for j in range(size):
            random = np.random.default_rng([SEED, i, j])
            # The middle is taller.
            tall = int(9 * max(0.0, 1 - np.hypot(i - (size - 1) / 2, j - (size - 1) / 2) / (0.4 * size + 0.5)))
            chosen = (shares * (1, 1 + tall / 3, 1, 1)).cumsum()
            plot = kinds[np.searchsorted(chosen, random.random() * chosen[-1])](random, tall)
            x, y = STREET + period * i, STREET + period * j
            here = np.s_[x:x + PLOT, y:y + PLOT]
            for name in "storeys", "pitched", "top", "wall":
                getattr(town, name)[here] = getattr(plot, name)
            town.rise[x:x + PLOT + 1, y:y + PLOT + 1] = plot.rise
    return town


def _add_tops(builder: SceneBuilder, town: _Cells) -> None:
    """Adds ground and roofs; a cell of a hip or a valley becomes two triangles."""
    count = len(town.storeys)
    i, j = (index.ravel() for index in np.indices((count, count)))
    x, y = i[:, None] + [0, 1, 1, 0], j[:, None] + [0, 0, 1, 1]
    rise = town.rise[x, y] * town.pitched.reshape(-1, 1)
    corner = np.stack([CELL * x, CELL * y, STOREY * town.storeys.reshape(-1, 1) + rise], axis=-1)
    bent = rise[:, 0] + rise[:, 2] != rise[:, 1] + rise[:, 3]
    # The fold runs through the corner that differs from the other three.
    along = np.where((rise[:, 0] != rise[:, 2])[:, None], [0, 1, 2, 3], [1, 2, 3, 0])
    folded = np.take_along_axis(corner, along[..., None], axis=1)[bent]
    halves = np.stack([folded[:, [0, 1, 2, 2]], folded[:, [0, 2, 3, 3]]], axis=1).reshape(-1, 4, 3)
    patches = np.concatenate([corner[~bent], halves])
    cell = np.concatenate([np.flatnonzero(~bent), np.repeat(np.flatnonzero(bent), 2)])
    order = np.argsort(cell, kind="stable")
    _add(builder, patches[order], town.top.ravel()[cell[order]])


def _add_walls(builder: SceneBuilder, town: _Cells) -> None:
    """Adds what stands between cells of different heights, storey by storey, with the gables."""
    count = len(town.storeys)
    patches, materials = [], []
    for step in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        for i, j in np.ndindex(count, count):
            beside = i + step[0], j + step[1]
            low = town.storeys[beside] if min(beside) >= 0 and max(beside) < count else town.storeys[i, j]
            if low >= town.storeys[i, j]:
                continue
            # The ends of the edge, the left one first as seen from the lower cell.
            middle, across = np.array([i + 0.5, j + 0.5]) + np.multiply(step, 0.5), np.array([-step[1], step[0]]) / 2
            ends = np.rint([middle - across, middle + across]).astype(int)
            heights = STOREY * np.arange(low, town.storeys[i, j] + 1)[:, None] * np.ones(2)
            rise = town.rise[tuple(ends.T)] * town.pitched[i, j]
            if rise.any():
                heights = np.vstack([heights, heights[-1] + rise])
            for under, over in pairwise(heights):
                left, right = CELL * ends[0], CELL * ends[1]
                corners = [(*left, under[0]), (*right, under[1]), (*right, over[1]), (*left, over[0])]
                if over[1] == under[1]:
                    corners = [corners[0], corners[1], corners[3], corners[3]]
                elif over[0] == under[0]:
                    corners[3] = corners[2]
                patches.append(corners)
                materials.append(town.wall[i, j])
    _add(builder, np.array(patches), np.array(materials, dtype=object))


def _add(builder, patches, materials):
    for material in dict.fromkeys(materials.tolist()):
        builder.add(patches[[one is material for one in materials.tolist()]], material)


def city(size: int) -> Scene:
    """A city of ``size`` x ``size`` plots under the sky, with the sun in the south-west; fronts face the air."""
    builder = SceneBuilder("city")
    town = _lay_out(size)
    _add_tops(builder, town)
    _add_walls(builder, town)
    edge = CELL * len(town.storeys)
    sun = np.array([-1.2, -0.7, 1.1]) * 4 * edge
    camera = Camera(eye=(-0.28 * edge, -0.5 * edge, 0.55 * edge), target=(0.5 * edge, 0.43 * edge, 0), fov=38.0)
    light = PointLight(position=tuple(sun.tolist()), intensity=tuple((sun @ sun * np.array([5.5, 5.0, 4.2])).tolist()))
    return builder.build(camera=camera, lights=(light,), background=(0.55, 0.72, 1.0))
