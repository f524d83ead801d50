"""Windows of a frustum's subshells, and the requests for grid rays that golden makes of them."""

from functools import cached_property

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector, sector_rays, subshell_rays
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.stimulus.ctu.grids import shells
from golden.engine.stimulus.ctu.records import TraversalRecord
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from radiosity.flow.package.example.frustum_load import frustum_payload
from radiosity.flow.package.example.grid_load import GridAddresses, grid_writes

__all__ = ["CASES", "FRUSTA", "SECTORS", "RecordStages", "WindowStages"]

FRUSTA = {"hemisphere": random_hemisphere, "screen": random_screen}
# By frustum: all of it; parts that reach the first column, the last one, and neither; a last row.
SECTORS = {"hemisphere": (None, (3, 40, 0, 12), (50, 64, 5, 16), (0, 20, 0, 3), (20, 21, 15, 16)),
           "screen": (None, (3, 40, 0, 12), (50, 60, 5, 45), (0, 1, 40, 45), (20, 21, 22, 23))}
WINDOWS = 9
STAGES = 16
CASES = ("last subshell", "window without rays", "stage without rows", "stage with rows but no rays", "whole ring",
         "window goes round", "sector goes round", "sector's border is all of the circle", "two pieces in a row",
         "a row is cut by the sector", "rows are cut by the sector", "first row", "screen", "screen's border",
         "beyond the last shell", "shell 1")


class WindowStages:
    """Random and hard windows.

    Members
    -------
    items, ports, tables
        What a `CtRayGenerator` is given.
    requests
        `CtuFormats.grid_request` in their order.
    rays
        By shell.
    """

    def __init__(self, kind: str, config: Config, *, seed: int, sector: int = 0, last_shell: int = 6):
        random = np.random.default_rng(seed)
        record, given = FRUSTA[kind](random, config), SECTORS[kind][sector]
        sector = Sector(*given) if given else Sector.whole(record)
        self._prepare(record, sector, shells(record), last_shell, config)
        self._give([*self._drawn(random), ((0, 0, 0, 0), 0, True)])

    def _prepare(self, record, sector, of, last_shell, config):
        self.record, self.sector, self.last_shell = record, sector, last_shell
        self.rays = {shell: of(shell) for shell in range(2, last_shell + 1)}
        self._addresses = GridAddresses(self.rays.values())
        self.tables = grid_writes(list(self.rays.values()), config)
        self.ports = {"frustum": frustum_payload(self.record, self.sector, config), "last_shell": last_shell}

    def _give(self, subshells):
        self.subshells, names = subshells, ("column_first", "column_count", "row_first", "row_count")
        self.items = [{"window": dict(zip(names, window, strict=True)), "shell": shell, "last": int(last)}
                      for window, shell, last in self.subshells]

    def _drawn(self, random):
        size = np.array([self.record.columns, self.record.rows])
        for number in range(WINDOWS):
            first = random.integers(size)
            most = size - first
            if not self.record.is_screen:
                most[0] = size[0]
            count = random.integers(1, most, endpoint=True)
            if number % 3 == 1:
                count = 1 + count // 8
            if number == 2:
                first[:], count[1] = 0, 1 + size[1] // 8
                count[0] = size[0]
            if number == 5:
                count[:] = 0
            if number == 7:
                first[0], count[0] = size[0] - 2, 2 if self.record.is_screen else 7
            yield ((int(first[0]), int(count[0]), int(first[1]), int(count[1])),
                   1 if number == 4 else int(random.integers(2, self.last_shell + 4)), False)

    def stages(self):
        """Window, shell, and the mask of the grid rays of each stage."""
        for window, shell, last in self.subshells:
            if not last and not window[1]:
                continue
            for one in range(2, (self.last_shell if last else min(shell, self.last_shell)) + 1):
                mask = sector_rays(self.rays[one], self.sector, self.record)
                yield None if last else window, one, mask if last else mask & subshell_rays(
                    self.rays[one], window, self.record)

    @cached_property
    def requests(self) -> list[dict]:
        """See above."""
        made = []
        for number, (_, shell, mask) in enumerate(self.stages()):
            stage = {"stage": number % STAGES}
            made += [{**self._addresses.request(self.rays[shell], int(ray)), **stage} for ray in np.flatnonzero(mask)]
            made.append({"shell": shell, "last": 1, **stage})
        return [*made, {"final": 1}]

    def only(self, items: slice) -> "WindowStages":
        """Leave all windows away but some and the last subshell."""
        self._give([*self.subshells[items], self.subshells[-1]])
        return self

    def hit(self, coverage) -> None:
        """Count the cases that these windows are."""
        record, sector = self.record, self.sector
        across = record.columns << 8
        for window, shell, _ in self.subshells:
            coverage.hit_all({"window without rays": not window[1], "shell 1": shell == 1,
                              "beyond the last shell": shell > self.last_shell})
        for window, shell, mask in self.stages():
            rays = self.rays[shell]
            own = sector_rays(rays, sector, record)
            requested = np.ones_like(own) if window is None else subshell_rays(rays, window, record)
            rows = requested.any(axis=1) & own.any(axis=1)
            pieces = (np.diff(np.pad(mask, ((0, 0), (1, 0))).astype(int), axis=1) == 1).sum(axis=1)
            before = (sector.first_column << 8) - rays.column_border
            beyond = (sector.end_column << 8) + rays.column_border
            coverage.hit_all({
                "last subshell": window is None, "stage without rows": not rows.any(),
                "stage with rows but no rays": rows.any() and not mask.any(),
                "whole ring": window is not None and window[1] == record.columns and not record.is_screen,
                "window goes round": window is not None and window[0] + window[1] > record.columns,
                "sector goes round": not record.is_screen and ((before < 0) | (beyond > across)).any(),
                "sector's border is all of the circle": not record.is_screen and own.all(axis=1).any()
                and record.columns > sector.end_column - sector.first_column,
                "two pieces in a row": pieces > 1,
                "a row is cut by the sector": (mask.sum(axis=1) < requested.sum(axis=1)) & mask.any(axis=1),
                "rows are cut by the sector": (requested.any(axis=1) & ~own.any(axis=1)).any() and mask.any(),
                "first row": mask[0].any(), "screen": record.is_screen and mask.any(),
                "screen's border": record.is_screen and (rays.column_position < 0).any()
                and mask[:, rays.column_position < 0].any()})


class RecordStages(WindowStages):
    """The subshells of one cluster in a scene, with golden's windows.

    Parameters
    ----------
    record
        The frustum.
    number
        Of the cluster.
    """

    def __init__(self, record: TraversalRecord, number: int, config: Config):
        played = record.sectors[number]
        cluster = record.shelling.cluster(record.record, played.sector)
        tests = record.shelling.tests(record.record, RayMemory(len(record.record), config))
        self._prepare(record.record, played.sector, cluster.traversal.rays, cluster.traversal.last_shell, config)
        windows = [tuple(map(int, tests.window(patch))) for patch in played.subshells.patches]
        listed = [(window, int(shell), False) for window, shell in zip(windows, played.subshells.shell, strict=True)]
        self._give([*listed, ((0, 0, 0, 0), 0, True)])
        # Of golden's stages how many rays were requested.
        self.scanned = {(one.stage.subshell, one.stage.shell): one.stage.scanned for one in played.played
                          if one.stage.shell > 1}

    def requested(self) -> dict[tuple[int, int], int]:
        """By subshell and shell how many rays are requested."""
        numbers = [number for number, (window, shell, last) in enumerate(self.subshells) if last or window[1]
                   for _ in range(2, (self.last_shell if last else min(shell, self.last_shell)) + 1)]
        return {(number, shell): int(mask.sum())
                for number, (_, shell, mask) in zip(numbers, self.stages(), strict=True)}
