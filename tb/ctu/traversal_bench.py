"""The environment of cell traversal's back end in a simulator: the front end, and the tests of patches."""

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, RisingEdge

from golden.engine.cast.cluster_casting import Stage
from golden.engine.cast.fixed_hits import read_out
from golden.engine.cast.shelling import ShellingCounts
from golden.engine.ctu.cell_traversal import Traversal
from golden.engine.ctu.sector import sector_rays, subshell_rays
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors_by_code
from golden.engine.ctu.unit import global_directions
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.icu.settle_code import settle_code
from golden.engine.memsys.patches.filter import Filter
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.stage_count import NEAR_STAGE
from hw.lib.payload import pack
from radiosity.flow.package.example.frustum_load import frustum_payload
from radiosity.flow.package.example.grid_load import GridAddresses, grouped, unit_writes
from radiosity.flow.package.example.settle_words import settle_words
from tb.lib.ports import Ports
from tb.lib.stream import now

__all__ = ["FINAL", "STAGES", "ClusterPart", "Intersection", "SettlePort", "Surroundings"]

# Stages are numbered modulo this.
STAGES = 16
# The request behind the last stage.
FINAL = {"final": 1}
# Cycles from a tile's last word to its squares, and more.
SWEEP = 60


class ClusterPart:
    """A cluster's part of a frustum, and what its traversal is given.

    Parameters
    ----------
    shelling, record, sector
        The scene with its cells, the frustum, the cluster's part.
    """

    def __init__(self, shelling, record, sector, config):
        self.shelling, self.record, self.sector, self.config = shelling, record, sector, config
        self.cluster = shelling.cluster(record, sector)
        self.traversal = traversal = self.cluster.traversal
        self.rays = {shell: traversal.rays(shell) for shell in range(2, traversal.last_shell + 1)}
        self.addresses = GridAddresses(self.rays.values())
        self.word, self._cells = CtuFormats(config).settle_word, {}
        self.tables = unit_writes(traversal, config)
        self.frustum = {
            "frustum": frustum_payload(record, sector, config), "to_global": record.to_global.tolist(),
            "grid_origin": shelling.table.position(record.origin).tolist(), "cells": shelling.table.shape.tolist()}
        near = traversal.open(1, None).tolist()
        self.near = [{"cell": cell, "is_cell": 1, "last": k == len(near) - 1}
                     for k, cell in enumerate(near)] or [{"last": 1}]
        self.tiles_across = self.frustum["frustum"]["tiles_across"]

    def cells(self, shell):
        """Of each grid ray of a shell the cells that it meets, in order."""
        if shell not in self._cells:
            self._cells[shell] = self._cells_of(shell)
        return self._cells[shell]

    def _cells_of(self, shell):
        record, rays, table = self.record, self.rays[shell], self.shelling.table
        begin, end = self.traversal.borders(shell)
        going = Traversal(table.position(record.origin), global_directions(rays.direction.reshape(-1, 3), record),
                          begin=begin, end=end, shape=table.shape)
        cells = [[] for _ in range(rays.rows * rays.columns)]
        while len(going.ray):
            inside = going.inside
            for ray, cell in zip(going.ray[inside].tolist(), table.number(going.index[inside]).tolist(), strict=True):
                cells[ray].append(cell)
            going.advance()
        return cells

    def numbers_of(self, shell, window):
        """Numbers of the grid rays of a stage."""
        inside = sector_rays(self.rays[shell], self.sector, self.record)
        if window is not None:
            inside &= subshell_rays(self.rays[shell], window, self.record)
        return np.flatnonzero(inside)

    def sent(self, played):
        """Of golden's stages behind the near cells', one after the other: the shell, and the grid rays that leave."""
        left = {shell: np.zeros(rays.rows * rays.columns, dtype=bool) for shell, rays in self.rays.items()}
        for one in played[1:]:
            shell, pyramid = one.stage.shell, SettlePyramid(one.codes, self.config)
            going = survivors_by_code(self.rays[shell], pyramid, one.threshold, self.sector, self.record).ravel()
            numbers = self.numbers_of(shell, one.stage.window)
            leaving = numbers[going[numbers] & ~left[shell][numbers]]
            left[shell][leaving] = True
            assert len(leaving) == one.stage.grid_rays
            yield shell, leaving

    def requests(self, stage, shell, window, chosen=None):
        """The requests of a stage, its number counted from 0 on; the last of them closes it."""
        numbers = self.numbers_of(shell, window) if chosen is None else chosen
        groups = grouped(self.addresses.request(self.rays[shell], int(number)) for number in numbers)
        return [*({**one, "stage": stage % STAGES} for one in groups),
                {"stage": stage % STAGES, "shell": shell, "last": 1}]

    def words(self, codes):
        """Settle codes of the section's rows and columns as words, tile by tile."""
        return [pack(self.word, tile) for tile in settle_words(codes, self.config)]


class SettlePort:
    """The settle map's port: a tile per cycle, in order, some cycles later.

    It stays from one frustum to the next, as what has been requested is answered; with a reset a new one begins.

    Members
    -------
    words
        The settle map's, which a test writes.
    stalls
        Share of the cycles in which it does not answer.
    sweeps
        How often its first tile has been requested.
    given
        Cycle, tile and word of each answer.
    """

    def __init__(self, dut):
        self._dut, self._settled = dut, (1 << len(dut.i_word__payload)) - 1
        self._random = np.random.default_rng(0)
        self.words, self.stalls, self.sweeps, self.given = [], 0.0, 0, []
        self._task = cocotb.start_soon(self._run())

    def stop(self):
        """Answer nothing more."""
        self._task.cancel()
        self._dut.o_tile__ready.value = self._dut.i_word__valid.value = 0

    async def _run(self):
        dut, edge, waiting, cycle = self._dut, RisingEdge(self._dut.clk), [], 0
        dut.o_tile__ready.value = 1
        dut.i_word__valid.value = 0
        offers = False
        while True:
            await edge
            cycle += 1
            if offers and int(dut.i_word__ready.value):
                self.given.append((now(), *waiting.pop(0)[1:]))
                offers = False
            if int(dut.o_tile__valid.value) and int(dut.o_tile__ready.value):
                tile = int(dut.o_tile__payload.value)
                self.sweeps += tile == 0
                # Where the last frustum has more tiles, its sweep still requests them: all is settled there.
                waiting.append((cycle + 4, tile, self.words[tile] if tile < len(self.words) else self._settled))
            if not offers:
                offers = bool(waiting) and waiting[0][0] <= cycle and self._random.random() >= self.stalls
                dut.i_word__valid.value = offers
                if offers:
                    dut.i_word__payload.value = waiting[0][2]
            dut.o_tile__ready.value = len(waiting) < 8


class Surroundings:
    """Streams of a `RayTraversal` or of a `TraversalUnit`, and a settle map that a test writes.

    Parameters
    ----------
    dut, component
        In the simulator, and its signature.
    part
        The cluster's.
    misses
        Share of the cycles in which the settle map does not answer.
    port
        The settle map's of the frustum before; without it one that is this frustum's alone.
    stalls, seed
        See `Ports`.

    Members
    -------
    ports
        All streams but the settle map's.
    cells, cycles
        What has come: cell and stage, the near cells' first, and in which cycles; ``final`` once it is over.
    begun
        The cycle in which the frustum was given.
    ahead
        Cells of stages behind the oldest one that is not over.
    heard
        Called with each cell.
    """

    def __init__(self, dut, component, part, *, misses=0.0, seed=0, port=None, **stalls):
        self.part, self.heard = part, None
        self.cells, self.cycles, self.final, self.ahead, self.begun = [], [], False, 0, None
        self.port, self._own_port = port or SettlePort(dut), port is None
        self.port.stalls = misses
        self.ports = Ports(dut, component, stalls=stalls, seed=seed, others=("o_tile", "i_word"))
        self.ports["settled"] = 1
        self.ports.run(self._follow())

    @property
    def over(self):
        """Stages that are over."""
        return len(self.ports.sinks["o_over"].items)

    def stop(self):
        """Nothing more."""
        self.ports.stop()
        if self._own_port:
            self.port.stop()

    async def _follow(self):
        """In the cycle in which a cell comes."""
        seen, run_ahead = 0, self.part.config.ctu.run_ahead
        while True:
            await self.ports.edge
            for cell, cycle in zip(self.ports.came("o", seen), self.ports.sinks["o"].cycles[seen:], strict=True):
                assert not self.final, "a cell came when the frustum was over"
                if cell["final"]:
                    self.final = True
                    continue
                self.cells.append((cell["cell"], cell["stage"]))
                self.cycles.append(cycle)
                if "o_over" in self.ports.sinks:
                    self.ahead += 0 < (cell["stage"] - self.over) % STAGES <= run_ahead
                if self.heard is not None:
                    self.heard(cell["cell"])
            seen = len(self.ports.sinks["o"].items)

    async def begin(self):
        """Tables, frustum, near cells."""
        await self.ports.send("i_table", self.part.tables)
        await self.ports.send("i_frustum", [self.part.frustum])
        self.begun = now()
        await self.ports.send("i_near", self.part.near)
        # The last of them has been seen.
        await ClockCycles(self.ports.dut.clk, 2)

    async def swept(self):
        """Until all squares are of the codes that are there now."""
        for more in (2, 3):
            until = self.port.sweeps + more - 1
            await self.ports.until(lambda until=until: self.port.sweeps >= until)
        await ClockCycles(self.ports.dut.clk, SWEEP)


class Intersection:
    """Finds the patches of cells and tests them, each cell after a time of its own.

    Parameters
    ----------
    around
        The surroundings, whose settle map it writes.
    delay
        From a random generator to the cycles that a cell takes.
    """

    def __init__(self, around, *, delay, seed):
        part = around.part
        self._around, self._part, self._delay = around, part, delay
        self._random = np.random.default_rng(seed)
        self.memory = RayMemory(len(part.record), part.config)
        self.tests = part.shelling.tests(part.record, self.memory)
        table = part.shelling.table
        self._cells, self._patches = Filter(len(table)), Filter(len(part.shelling.geometry))
        self._waiting, self._counts = [], ShellingCounts()
        self._show()
        around.heard = self._hear
        self._task = cocotb.start_soon(self._run())

    def _show(self):
        record, sector = self._part.record, self._part.sector
        codes = settle_code(self.memory.inverse.reshape(record.rows, record.columns), self._part.config)
        self._around.port.words = self._part.words(
            codes[sector.first_row:sector.end_row, sector.first_column:sector.end_column])

    def _hear(self, cell):
        self._waiting.append([int(self._delay(self._random)), cell])
        self._settle()

    def _settle(self):
        """Whether no cell leads to anything any more."""
        self._around.ports["settled"] = not self._waiting

    async def _run(self):
        while True:
            self._settle()
            await self._around.ports.edge
            for one in self._waiting:
                one[0] -= 1
            due = [cell for left, cell in self._waiting if left <= 0]
            if due:
                self._waiting = [one for one in self._waiting if one[0] > 0]
                self._test(np.array(due))

    def _test(self, cells):
        table = self._part.shelling.table
        opened = self._cells.first(cells)
        found = self._patches.first(table.patches.read(table.entries(opened)))
        if len(found):
            stage = Stage(subshell=0, shell=2, window=None, scanned=0, grid_rays=0, cell_steps=0, passes=0,
                          cells=cells, opened=opened, found=found)
            self.tests.run(stage, self._part.sector, self._counts)
            self._show()

    @property
    def idle(self):
        """No cell waits for its patches' tests."""
        return not self._waiting

    def stop(self):
        """Test nothing more."""
        self._task.cancel()
        self._around.heard = None

    def hits(self):
        """What the rays hit."""
        return read_out(self.memory, self._part.record, self.tests.patches, self._part.config)


assert NEAR_STAGE == STAGES - 1
