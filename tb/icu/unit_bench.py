"""Driving a whole intersection unit: frusta in, hits and sums out."""

import numpy as np

from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.scene.patch_geometry import PatchGeometry
from hw.icu.intersection_unit import IntersectionUnit
from radiosity.flow.package.example.frustum_load import frustum_payload, table_writes
from tb.lib.ports import Ports

__all__ = ["UnitBench", "section_hits", "vertices"]


class UnitBench:
    """An intersection unit in the simulator.

    Parameters
    ----------
    dut, config
        The unit, and its configuration.
    seed
        Of the stall patterns; default: the run's.
    stalls
        By stream the name of a stall pattern, or a pattern.
    """

    def __init__(self, dut, config: Config, *, seed: int | None = None, **stalls):
        self.config = config
        self.ports = Ports(dut, IntersectionUnit(config=config), stalls=stalls, seed=seed)
        self.sums: list[tuple[int, int]] = []
        self.ports["patches"] = 1 << config.icu.patch_bits

    async def begin(self, record: FrustumRecord, section: Sector, weights: np.ndarray | None = None) -> None:
        """Write a frustum's tables, and its numbers."""
        await self.ports.send("i_table", table_writes(record, self.config, weights))
        await self.ports.send("i_frustum", [frustum_payload(record, section, self.config)])

    async def cast(self, geometry: PatchGeometry, order: np.ndarray) -> None:
        """Send patches, and wait until each of them has its token."""
        self.ports.begin("i_vertex", vertices(geometry, order))
        assert await self.ports.take("o_done", len(order)) == order.tolist(), "tokens must come in the patches' order"

    async def hits(self, section: Sector) -> FixedHits:
        """Read out the section of the present frustum, and its sums into ``sums``."""
        sums = self.ports.sinks["o_sum"].items
        first_sum = len(sums)
        self.ports.begin("i_read_out", [0])
        found = await self.ports.take("o_hit", section.rays)
        assert len(sums) == first_sum, "sums must come after the hits"
        columns, rows = np.meshgrid(np.arange(section.first_column, section.end_column),
                                    np.arange(section.first_row, section.end_row))
        assert [(ray["column"], ray["row"]) for ray in found] == list(
            zip(columns.ravel().tolist(), rows.ravel().tolist(), strict=True)), "rays must come in their order"
        assert [ray["last"] for ray in found] == [0] * (len(found) - 1) + [1]
        inverse, patch, u, v = (np.array([ray["hit"][name] for ray in found]) for name in
                                ("inverse", "patch", "u", "v"))
        await self._keep_sums()
        return FixedHits(inverse=inverse, patch=np.where(inverse > 0, patch, -1), u=u, v=v)

    async def _keep_sums(self):
        """The sums of the section, up to the last one."""
        found = []
        while not (found and found[-1]["last"]):
            found += await self.ports.take("o_sum", 1)
        assert [entry["is_sum"] for entry in found] in ([1] * len(found), [0])
        self.sums = [(entry["patch"], entry["sum"]) for entry in found if entry["is_sum"]]


def vertices(geometry: PatchGeometry, order: np.ndarray) -> list[dict]:
    """The vertex items of some patches."""
    return [{"patch": patch, "surface": int(geometry.surface[patch]), "vertex": vertex}
            for patch in order.tolist() for vertex in geometry.vertices[patch].tolist()]


def section_hits(hits: FixedHits, record: FrustumRecord, section: Sector) -> FixedHits:
    """The hits of a section's rays, row by row."""
    own = section.mask(record).ravel()
    return FixedHits(inverse=hits.inverse[own], patch=hits.patch[own], u=hits.u[own], v=hits.v[own])
