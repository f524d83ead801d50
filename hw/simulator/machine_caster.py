"""The simulated machine as a caster of frusta for the renderer."""

import numpy as np

from golden.cast.fixed_frusta import CONFIG, FixedFrusta
from golden.cast.shelling import Shelling
from golden.config import Config
from golden.errors import InputError
from golden.frustum import FrustumRecord
from golden.memory_map import machine_image
from golden.plural import counted
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene
from golden.schedule.cell_choice import choose_cell
from golden.schedule.phase import machine_schedule
from hw.simulator.simulated_machine import SimulatedMachine
from hw.simulator.simulation_config import overridden_text

__all__ = ["MachineCaster"]

# Frusta that share a schedule, and rays of a frustum for each ray cast to schedule it.
PHASE, RATIO = 64, 16


class MachineCaster(FixedFrusta):
    """Casts hemispheres and screens on a machine, with the hits of `golden.cast.fixed_frusta.ShellingFrusta`.

    The tests and cell steps of a frustum are divided evenly among its rays. The machine's sums of a hemisphere are
    compared with its hits.

    Parameters
    ----------
    scene
        The patches.
    machine
        The machine.
    cell
        Cell size as a share of the scene's longest side; None: `golden.schedule.cell_choice` chooses it for each
        request, from some of its frusta.
    changes
        What the simulation has overridden, see `hw.simulator.simulation_config.overridden`.

    Members
    -------
    frusta, rays, cycles, tested
        Totals since the start: frusta, their rays, cycles of their casts, and tests.
    cells
        Frusta by cell size.

    Raises
    ------
    InputError
        Cell size out of range, or the machine's number formats are not those of golden's frusta.
    RuntimeError
        The machine's sums are not those of its hits.
    """

    def __init__(self, scene: Scene, machine: SimulatedMachine, *, cell: float | None, changes: dict | None = None):
        self.check(machine.config)
        self._simulated, self._cell, self._weights = machine, cell, None
        self._changes = changes or {}
        self.frusta = self.rays = self.cycles = self.tested = 0
        self.cells: dict[float, int] = {}
        super().__init__(scene)

    @staticmethod
    def check(config: Config) -> None:
        """Refuse a machine whose hits golden's float64 arithmetic cannot continue with.

        Raises
        ------
        InputError
            Its number formats are not those of golden's frusta.
        """
        if config.numbers != CONFIG.numbers:
            raise InputError("machine: Number formats (numbers.*) must be the default ones for images and form factors")

    def hemispheres(self, hemisphere, points, frames, surfaces):
        """See `FixedFrusta`."""
        self._weights = hemisphere.polar_weights
        return super().hemispheres(hemisphere, points, frames, surfaces)

    def screen(self, screen, side):
        """See `FixedFrusta`."""
        self._weights = None
        return super().screen(screen, side)

    def counts(self) -> dict[str, object]:
        """The members above."""
        return {name: getattr(self, name) for name in ("frusta", "rays", "cycles", "tested", "cells")}

    def summary(self) -> str:
        """The members above and what the simulation has overridden, in a line."""
        efficiency = self.tested / max(1, self.cycles) / self._simulated.config.noc.nodes
        noc = self._simulated.config.noc
        cells = ", ".join(f"{cell:g}" for cell in self.cells) + (" (chosen)" if self._cell is None else "")
        return (f"machine: {counted(noc.nodes, 'cluster')}, {noc.topology}, cell {cells}, {self.frusta} frusta, "
                f"{self.rays} rays, {self.cycles} cycles, pipeline efficiency {efficiency:.3f}, "
                f"{self.tested / max(1, self.rays):.2f} tests per ray{overridden_text(self._changes)}")

    def _samples_in(self, geometry):
        """The samples of the last request, once; none if another geometry's coordinates have been requested since."""
        coordinates, samples = self._samples
        if coordinates is not geometry.coordinates:
            return []
        self._samples = None, []
        return samples

    def _machine(self, geometry: PatchGeometry):
        config = self._simulated.config
        table, cell, plan, left = None, self._cell, None, 0

        def cast(record: FrustumRecord):
            nonlocal table, cell, plan, left
            if self._cell is None and ((samples := self._samples_in(geometry)) or cell is None):
                chosen = choose_cell(samples or [record], geometry, config).cell
                if chosen != cell:
                    table, cell, plan = None, chosen, None
            if table is None:
                table = Shelling(geometry, config, cell=cell).table
            fits = plan and (record.columns, record.rows) == (plan.partition.columns, plan.partition.rows)
            if not fits or not left:
                plan = machine_schedule(record, geometry, table, config, ratio=RATIO)
                left = PHASE
            left -= 1
            self.cells[cell] = self.cells.get(cell, 0) + 1
            weights = None if record.is_screen else self._weights
            image = machine_image(record, geometry, table, config, plan, weights=weights)
            return self._results(record, image, weights)
        return cast

    def _results(self, record, image, weights):
        total = 0 if weights is None else int(weights.sum()) * record.columns
        done = self._simulated.cast(image, total=total, sums=weights is not None)
        hits = done.image.hits()
        if weights is not None and (done.image["sums"] != image.with_results(hits)["sums"]).any():
            raise RuntimeError("The machine's sums are not those of its hits")
        count = len(record)
        self.frusta, self.rays, self.cycles = self.frusta + 1, self.rays + count, self.cycles + done.cycles
        self.tested += done.total("intersection_tested")
        return hits, *(self._shares(done.total(name), count) for name in ("intersection_tested", "traversal_steps"))

    @staticmethod
    def _shares(total, count):
        share, rest = divmod(total, count)
        return share + (np.arange(count) < rest)
