"""The simulated machine as a caster of frusta for the renderer."""

from collections.abc import Sequence

import numpy as np

from golden.base.errors import InputError
from golden.base.plural import counted
from golden.base.progress_bar import progress_bar
from golden.engine.cast.fixed_frusta import CELL, CONFIG, FixedFrusta, blocked_by_shelling, shares
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.jobs.job import PhaseRequest
from golden.engine.jobs.phase_request import phase_request
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.cell_choice import choose_cell
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.scene import Scene
from radiosity.flow.simulator.simulated_machine import SimulatedMachine
from radiosity.flow.simulator.simulation_config import overridden_text

__all__ = ["MachineCaster"]

# Rays of a frustum for each ray cast to schedule it.
RATIO = 16


class MachineCaster(FixedFrusta):
    """Casts hemispheres and screens on a machine, with the hits of `golden.engine.cast.fixed_frusta.ShellingFrusta`.

    All hemispheres of a request are one job, or several of `together` rays each; so is a screen. Of the hits the
    machine writes the patches; positions follow from rays and patches. The machine's sums of a hemisphere are compared
    with its hits. The tests and cell steps of a frustum are divided evenly among its rays.

    Parameters
    ----------
    scene
        The patches.
    machine
        The machine.
    cell
        Cell size as a share of the scene's longest side; None: `golden.engine.schedule.cell_choice` chooses it for each
        request, from some of its frusta.
    changes
        What the simulation has overridden, see `radiosity.flow.simulator.simulation_config.overridden`.
    progress
        Show a bar for jobs that take more than two seconds.

    Members
    -------
    jobs, frusta, rays, cycles, tested
        Totals since the start: jobs, their frusta and rays, their cycles from doorbell to last result, and tests.
    cells
        Frusta by cell size.
    kinds
        Of ``hemispheres`` and of ``screens``: rays and cycles.

    Raises
    ------
    InputError
        Cell size out of range, or the machine's number formats are not those of golden's frusta.
    RuntimeError
        The machine's sums are not those of its hits.
    """

    together = 1 << 22

    def __init__(self, scene: Scene, machine: SimulatedMachine, *, cell: float | None, changes: dict | None = None,
                 progress: bool = False):
        self.check(machine.config)
        self._simulated, self._cell, self._weights = machine, cell, None
        self._changes, self._progress = changes or {}, progress
        self.jobs = self.frusta = self.rays = self.cycles = self.tested = 0
        self.cells: dict[float, int] = {}
        self.kinds: dict[str, dict[str, int]] = {}
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
        return {name: getattr(self, name) for name in ("jobs", "frusta", "rays", "cycles", "tested", "cells", "kinds")}

    def summary(self) -> str:
        """The members above and what the simulation has overridden, in a line."""
        efficiency = self.tested / max(1, self.cycles) / self._simulated.config.noc.clusters
        noc = self._simulated.config.noc
        rates = ", ".join(f"{kind} {one['rays'] / one['cycles']:.3f}" for kind, one in self.kinds.items())
        cells = ", ".join(f"{cell:g}" for cell in self.cells) + (" (chosen)" if self._cell is None else "")
        return (f"machine: {counted(noc.clusters, 'cluster')}, {noc.topology}, cell {cells}, "
                f"{counted(self.jobs, 'job')}, {self.frusta} frusta, {self.rays} rays, {self.cycles} cycles, "
                f"rays per cycle: {rates or 'none'}, pipeline efficiency {efficiency:.3f}, "
                f"{self.tested / max(1, self.rays):.2f} tests per ray{overridden_text(self._changes)}")

    def _samples_in(self, geometry):
        """The samples of the last request, once; none if another geometry's coordinates have been requested since."""
        coordinates, samples = self._samples
        if coordinates is not geometry.coordinates:
            return []
        self._samples = None, []
        return samples

    def _shadow_machine(self, geometry):
        # The host casts shadow rays, in the integers of the other frusta.
        return blocked_by_shelling(geometry, CELL)

    def _machine(self, geometry: PatchGeometry):
        config = self._simulated.config
        table, cell = None, self._cell

        def cast(records: Sequence[FrustumRecord]):
            nonlocal table, cell
            if self._cell is None and ((samples := self._samples_in(geometry)) or cell is None):
                chosen = choose_cell(samples or records[:1], geometry, config).cell
                if chosen != cell:
                    table, cell = None, chosen
            if table is None:
                table = job_shelling(geometry, config, cell=cell).table
            self.cells[cell] = self.cells.get(cell, 0) + len(records)
            weights = None if records[0].is_screen else self._weights
            return self._results(phase_request(
                records, geometry, table, config, ratio=RATIO, weights=weights, hit_format=HitFormat.IDS,
                sums=weights is not None))
        return cast

    def _results(self, request: PhaseRequest):
        """Patch, tests and steps of each ray of each frustum."""
        with progress_bar(desc="machine", unit="section", delay=2, leave=False, disable=not self._progress) as bar:
            done = self._simulated.run([request], progress=lambda completed: bar.update(completed - bar.n))
        (frusta,), count = done.frusta, len(request.records[0])
        self.jobs, self.frusta, self.rays = self.jobs + 1, self.frusta + len(frusta), self.rays + len(frusta) * count
        kind = self.kinds.setdefault("screens" if request.records[0].is_screen else "hemispheres",
                                     {"rays": 0, "cycles": 0})
        kind["rays"] += len(frusta) * count
        kind["cycles"] += done.cycles.total
        self.cycles += done.cycles.total
        for record, one in zip(request.records, frusta, strict=True):
            if one.sums is not None and (one.sums != _sums_of(record, one.hits, request)).any():
                raise RuntimeError("The machine's sums are not those of its hits")
            self.tested += one.total("tested")
            yield one.hits, *(shares(one.total(name), count) for name in ("tested", "steps"))


def _sums_of(record, patch, request):
    """N int64: of each patch the weights of the rays that hit it."""
    met, sums = np.flatnonzero(patch >= 0), np.zeros(len(request.geometry), dtype=np.int64)
    np.add.at(sums, patch[met], request.weights[met // record.columns])
    return sums
