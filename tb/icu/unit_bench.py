"""Driving a whole intersection unit: frusta in, hits and sums out."""

import numpy as np
from cocotb.triggers import RisingEdge

from golden.cast.fixed_hits import FixedHits
from golden.config import Config
from golden.ctu.sector import Sector
from golden.frustum import FrustumRecord
from golden.scene.patch_geometry import PatchGeometry
from hw.icu.icu_formats import IcuFormats
from hw.icu.intersection_unit import COUNTERS, IntersectionUnit
from tb.icu.frustum_load import frustum_payload, table_writes
from tb.lib.payload import pack, unpack
from tb.lib.stream import Sink, Source

__all__ = ["UnitBench"]


class UnitBench:
    """The streams of an intersection unit in the simulator.

    Parameters
    ----------
    dut, config
        The unit, and its configuration.
    vertex_stalls, done_stalls, hit_stalls
        Of its busiest streams.
    """

    def __init__(self, dut, config: Config, *, vertex_stalls=None, done_stalls=None, hit_stalls=None):
        self.dut, self.config, self.formats = dut, config, IcuFormats(config)
        signature = IntersectionUnit(config=config).signature
        self._shapes = {name: signature.members[name].signature.members["payload"].shape
                        for name in ("o_hit", "o_sum")}
        self.frustum, self.table = Source(dut, "i_frustum"), Source(dut, "i_table")
        self.vertex = Source(dut, "i_vertex", stalls=vertex_stalls)
        self.read_out = Source(dut, "i_read_out")
        self.settle = Source(dut, "i_settle")
        self.done = Sink(dut, "o_done", stalls=done_stalls)
        self.hit = Sink(dut, "o_hit", stalls=hit_stalls)
        self.sum, self.settled = Sink(dut, "o_sum"), Sink(dut, "o_settle")
        self.sums: list[tuple[int, int]] = []
        self._edge = RisingEdge(dut.clk)
        dut.patches.value = 1 << config.icu.patch_bits

    async def begin(self, record: FrustumRecord, section: Sector, weights: np.ndarray | None = None) -> None:
        """Write a frustum's tables, and its numbers."""
        formats = self.formats
        await self.table.send([pack(formats.table_write, write) for write in
                               table_writes(record, self.config, weights)])
        await self.frustum.send([pack(formats.frustum, frustum_payload(record, section, self.config))])

    def vertices(self, geometry: PatchGeometry, order: np.ndarray) -> list[int]:
        """The vertex items of some patches."""
        shape = self.formats.patch_vertex
        return [pack(shape, {"patch": int(patch), "surface": int(geometry.surface[patch]), "vertex": vertex})
                for patch in order for vertex in geometry.vertices[patch].tolist()]

    async def cast(self, geometry: PatchGeometry, order: np.ndarray) -> None:
        """Send patches, and wait until each of them has its token."""
        start = len(self.done.items)
        await self.vertex.send(self.vertices(geometry, order))
        while len(self.done.items) - start < len(order):
            await self._edge
        assert self.done.items[start:] == [int(patch) for patch in order], "tokens must come in the patches' order"

    async def hits(self, section: Sector) -> FixedHits:
        """Read out the section of the present frustum, and its sums into ``sums``."""
        rays = section.rays
        start, first_sum = len(self.hit.items), len(self.sum.items)
        await self.read_out.send([0])
        while len(self.hit.items) - start < rays:
            await self._edge
        assert len(self.sum.items) == first_sum, "sums must come after the hits"
        found = [unpack(self._shapes["o_hit"], item) for item in self.hit.items[start:]]
        columns, rows = np.meshgrid(np.arange(section.first_column, section.end_column),
                                    np.arange(section.first_row, section.end_row))
        assert [(ray["column"], ray["row"]) for ray in found] == list(
            zip(columns.ravel().tolist(), rows.ravel().tolist(), strict=True)), "rays must come in their order"
        assert [ray["last"] for ray in found] == [0] * (rays - 1) + [1]
        inverse, patch, u, v = (np.array([ray["hit"][name] for ray in found]) for name in
                                ("inverse", "patch", "u", "v"))
        await self._keep_sums(first_sum)
        return FixedHits(inverse=inverse, patch=np.where(inverse > 0, patch, -1), u=u, v=v)

    async def _keep_sums(self, first):
        """The sums of the section, up to the last one."""
        found = []
        while not (found and found[-1]["last"]):
            while len(self.sum.items) == first + len(found):
                await self._edge
            found.append(unpack(self._shapes["o_sum"], self.sum.items[first + len(found)]))
        assert [entry["is_sum"] for entry in found] in ([1] * len(found), [0])
        self.sums = [(entry["patch"], entry["sum"]) for entry in found if entry["is_sum"]]

    def counters(self) -> dict[str, int]:
        """The counters as they are."""
        shape = IntersectionUnit(config=self.config).signature.members["counters"].shape
        return {name: unpack(shape, int(self.dut.counters.value))[name] for name in COUNTERS}


def section_hits(hits: FixedHits, record: FrustumRecord, section: Sector) -> FixedHits:
    """The hits of a section's rays, row by row."""
    own = section.mask(record).ravel()
    return FixedHits(inverse=hits.inverse[own], patch=hits.patch[own], u=hits.u[own], v=hits.v[own])
