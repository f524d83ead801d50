"""Subshells of hard and random patches around the origin of a frustum, and golden's windows of them."""

import numpy as np

from golden.config import Config
from golden.ctu.sector import Sector
from golden.icu.edge_planes import edge_planes
from golden.icu.g2r_transform import g2r_transform
from golden.icu.ipbb import ImagePlaneWindows
from golden.icu.sbb import SphericalWindows
from golden.icu.vertex_direction import vertex_direction
from golden.stimulus.frusta import SOURCE, random_hemisphere, random_screen
from golden.stimulus.patches import scene_patches
from tb.icu.frustum_load import frustum_payload, table_writes

__all__ = ["CASES", "FRUSTA", "SubshellPatches"]

FRUSTA = {"hemisphere": random_hemisphere, "screen": random_screen}
CASES = ("quad", "triangle", "without rays", "the source's own", "all columns", "around the pole", "goes round",
         "one ray", "screen", "last subshell")


class SubshellPatches:
    """``count`` subshells and the last one.

    Members
    -------
    record, config
        The frustum, and the configuration.
    items, ports, tables
        What `SubshellWindows` is given.
    windows
        `Formats.subshell_window`, of those that have rays.
    """

    def __init__(self, kind: str, config: Config, *, seed: int, count: int):
        random = np.random.default_rng(seed)
        self.config, self.record = config, FRUSTA[kind](random, config)
        self.vertices = scene_patches(random, count, self.record.origin, config.numbers)
        self.surface = random.integers(0, 4 * SOURCE, count)
        shell = random.integers(1, 1 << config.ctu.shell_bits, count)
        directions, _ = vertex_direction(g2r_transform(self.record, self.vertices), config.numbers)
        planes = edge_planes(directions, config.numbers)
        maker = (ImagePlaneWindows if self.record.is_screen else SphericalWindows)(self.record, config)
        self.window = window = maker.windows(directions, planes)
        self.own = (self.surface == self.record.source) & (self.record.source >= 0)
        self.kept = ~self.own & (window.rays > 0)
        # Any order, and some of them twice.
        self.patches = random.permutation(np.concatenate([np.arange(count), np.arange(0, count, 7)]))[:count]
        self.items = [{"patch": int(patch), "shell": int(shell[patch])} for patch in self.patches] + [{"last": 1}]
        self.windows = [{"shell": int(shell[patch]), "last": 0, "window": {
            name: int(getattr(window, name)[patch])
            for name in ("column_first", "column_count", "row_first", "row_count")}}
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
