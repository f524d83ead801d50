"""Subshells of hard and random patches around the origin of a frustum, and golden's windows of them."""

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.edge_planes import edge_planes
from golden.engine.icu.g2r_transform import g2r_transform
from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.stimulus.frusta import SOURCE, random_hemisphere, random_screen
from golden.engine.stimulus.patches import scene_patches
from radiosity.flow.package.example.frustum_load import frustum_payload, table_writes
from tb.icu.vectors import WINDOW

__all__ = ["CASES", "FRUSTA", "SubshellPatches"]

# Patches that are drawn at once to find such as stand at the border of a ray, and by how many units of G they move.
MANY, MOVE = 10_000, 4
FRUSTA = {"hemisphere": random_hemisphere, "screen": random_screen}
CASES = ("quad", "triangle", "without rays", "the source's own", "all columns", "around the pole", "goes round",
         "one ray", "screen", "last subshell")


class SubshellPatches:
    """``count`` subshells and the last one.

    Parameters
    ----------
    size
        Of the frustum: columns and rows. Default: few.
    at_borders
        All patches are seen, and where their windows only just begin or end: see `patches_at_borders`.

    Members
    -------
    record, config
        The frustum, and the configuration.
    items, ports, tables
        What `SubshellWindows` is given.
    windows
        `CtuFormats.subshell_window`, of those that have rays.
    """

    def __init__(self, kind: str, config: Config, *, seed: int, count: int, size=None, at_borders: bool = False):
        random = np.random.default_rng(seed)
        self.config, self.record = config, FRUSTA[kind](random, config, **({"size": size} if size else {}))
        self.vertices = (patches_at_borders(random, count, self.record, config) if at_borders
                         else scene_patches(random, count, self.record.origin, config.numbers))
        # The source's own, others, and such as differ from it in one bit.
        self.surface = np.where(random.random(count) < 0.5, random.integers(0, 4 * SOURCE, count),
                                SOURCE ^ 1 << random.integers(0, 32, count))
        shell = random.integers(1, 1 << config.ctu.shell_bits, count)
        self.window = window = windows(self.record, self.vertices, config)
        self.own = (self.surface == self.record.source) & (self.record.source >= 0)
        self.kept = ~self.own & (window.rays > 0)
        # Any order, and some of them twice.
        self.patches = random.permutation(np.concatenate([np.arange(count), np.arange(0, count, 7)]))[:count]
        self.items = [{"patch": int(patch), "shell": int(shell[patch])} for patch in self.patches] + [{"last": 1}]
        self.windows = [{"shell": int(shell[patch]), "last": 0, "window": {
            name: int(getattr(window, name)[patch]) for name in WINDOW}}
            for patch in self.patches if self.kept[patch]] + [{"last": 1}]
        self.ports = {"frustum": frustum_payload(self.record, Sector.whole(self.record), config)}
        self.tables = table_writes(self.record, config)

    def beats(self, patch: int) -> list[dict]:
        """The four `Formats.patch_vertex` of a patch."""
        return [{"patch": patch, "surface": int(self.surface[patch]), "vertex": vertex.tolist()}
                for vertex in self.vertices[patch]]

    def hit(self, coverage) -> None:
        """Count the cases that these subshells are."""
        window, patches, record = self.window[self.patches], self.patches, self.record
        triangle = (self.vertices[:, 2] == self.vertices[:, 3]).all(axis=1)
        coverage.hit_all({
            "quad": self.kept & ~triangle, "triangle": self.kept & triangle, "without rays": window.rays == 0,
            "the source's own": self.own[patches] & (window.rays > 0),
            "all columns": (window.column_count == record.columns) & (not record.is_screen),
            "around the pole": (window.column_count == record.columns) & (window.row_first == 0)
            & (window.row_count > 0) & (not record.is_screen),
            "goes round": window.column_first + window.column_count > record.columns, "one ray": window.rays == 1,
            "screen": self.kept & record.is_screen, "last subshell": True})


def windows(record: FrustumRecord, vertices: np.ndarray, config: Config):
    """Golden's windows of patches in G coordinates."""
    directions, _ = vertex_direction(g2r_transform(record, vertices), config.numbers)
    maker = (ImagePlaneWindows if record.is_screen else SphericalWindows)(record, config)
    return maker.windows(directions, edge_planes(directions, config.numbers))


def patches_at_borders(random: np.random.Generator, count: int, record: FrustumRecord, config: Config) -> np.ndarray:
    """Patches whose windows are others as soon as they move by a few units: count x 4 x 3 int64, G coordinates.

    Of any others the low bits of what windows are made of hardly ever matter.
    """
    found = np.empty((0, 4, 3), dtype=np.int64)
    while len(found) < count:
        drawn = patches_in_view(random, MANY, record, config)
        moved = np.clip(drawn + random.integers(-MOVE, MOVE + 1, (MANY, 1, 3)), 0, config.numbers.scene.high)
        before, after = (windows(record, vertices, config) for vertices in (drawn, moved))
        differ = np.any([getattr(before, name) != getattr(after, name) for name in WINDOW], axis=0)
        found = np.concatenate([found, drawn[differ]])
    return found[:count]


def patches_in_view(random: np.random.Generator, count: int, record: FrustumRecord, config: Config) -> np.ndarray:
    """Quads and triangles of all sizes around points that rays meet, as `scene_patches` gives them."""
    column, row = (random.integers(size, size=count) for size in (record.columns, record.rows))
    directions = record.directions(column, row)
    away = np.linalg.solve(record.matrix.astype(float), directions[..., None].astype(float))[:, None, :, 0]
    away *= 2.0 ** (config.numbers.scene_bits + random.uniform(-6, -1.5, (count, 1, 1)))
    first, second = (random.normal(size=(count, 1, 3)) * np.linalg.norm(away, axis=2, keepdims=True)
                     * 2.0 ** random.uniform(-10, -1, (count, 1, 1)) for _ in range(2))
    patches = np.concatenate([away - first - second, away + first - second, away + first + second,
                              away - first + second], axis=1)
    patches[::3, 3] = patches[::3, 2]
    return np.clip(record.origin + np.rint(patches).astype(np.int64), 0, config.numbers.scene.high)
