"""The simulated machine as a caster of frusta for the renderer."""

from collections.abc import Iterator, Sequence

import numpy as np

from golden.base.errors import InputError
from golden.base.plural import counted
from golden.base.progress_bar import progress_bar
from golden.cast.density import Level
from golden.engine.cast.fixed_frusta import CELL, CONFIG, SAMPLES, FixedFrusta, blocked_by_shelling, shares
from golden.engine.cast.shadow_frusta import MOST_BITS
from golden.engine.cast.specular_frusta import SpecularCaster
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.frustum.shadow_record import ShadowRecord
from golden.engine.jobs.job import PhaseRequest
from golden.engine.jobs.phase_request import phase_request
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.tile_sections import window_sections
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.cell_choice import choose_cell
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.scene import Scene
from radiosity.flow.simulator.job_result import FrustumResult
from radiosity.flow.simulator.simulated_machine import SimulatedMachine
from radiosity.flow.simulator.simulation_config import overridden_text

__all__ = ["MachineCaster"]

# Rays of a frustum for each ray cast to schedule it.
RATIO = 16
# Names of kinds of frusta.
KINDS = {Bundle.HEMISPHERE: "hemispheres", Bundle.SCREEN: "screens", Bundle.SHADOW: "shadow frusta"}


class MachineCaster(FixedFrusta):
    """Casts hemispheres and screens on a machine, with the hits of `golden.engine.cast.fixed_frusta.ShellingFrusta`.

    All hemispheres of a request are one job, or several of `together` rays each; so is a screen, and so are shadow
    frusta of the same grid on a machine with ``icu.shadow_bits``. Without them the host casts shadow rays, in the
    integers of the other frusta. A shadow frustum whose list is too long is cast part by part. Of the hits the machine
    writes the patches, of shadow rays bits; positions follow from rays and patches. The machine's sums of a hemisphere
    are compared with its hits. The tests and cell steps of a frustum are divided evenly among its rays.

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
        Of ``hemispheres``, ``screens``, ``specular frusta`` and ``shadow frusta``: frusta, rays, cycles and tests. Rays
        of a shadow frustum are those of its list.

    Raises
    ------
    InputError
        Cell size out of range, or see `check`.
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
        self._shadow_cells: _Cells | None = None
        self._specular: SpecularCaster | None = None
        super().__init__(scene)

    @staticmethod
    def check(config: Config) -> None:
        """Refuse a machine whose hits golden's float64 arithmetic cannot continue with.

        Raises
        ------
        InputError
            Its number formats are not those of golden's frusta, or its shadow frusta are smaller.
        """
        if config.numbers != CONFIG.numbers:
            raise InputError("machine: Number formats (numbers.*) must be the default ones for images and form factors")
        if config.icu.shadow_bits and config.icu.side_bits < MOST_BITS:
            raise InputError(f"machine: Shadow frusta (icu.shadow_bits) need an icu.side_bits of at least {MOST_BITS} "
                             f"here, not {config.icu.side_bits}")

    def hemispheres(self, hemisphere, points, frames, surfaces):
        """See `FixedFrusta`."""
        self._weights = hemisphere.polar_weights
        return super().hemispheres(hemisphere, points, frames, surfaces)

    def screen(self, screen, side):
        """See `FixedFrusta`."""
        self._weights = None
        return super().screen(screen, side)

    def specular(self, screen, side):
        """See `FixedFrusta`."""
        self._specular = super().specular(screen, side)
        return self._specular

    def dense_hemispheres(self, density, hemisphere, points, frames, surfaces):
        """See `FixedFrusta`.

        Raises
        ------
        InputError
            The finest grid has more azimuths or polar angles than the machine counts, or it has subshell lists.
        """
        if self._simulated.config.ctu.subshells:
            raise InputError("machine: Rays cast again need clusters without lists of subshells (ctu.subshell_bits), "
                             f"not {self._simulated.config.ctu.subshell_bits!r}")
        bits, finest = self._simulated.config.icu.side_bits, Level(hemisphere, density.depth(hemisphere)).grid
        needed = max(finest.azimuths, finest.polars).bit_length() - 1
        if needed > bits:
            raise InputError(f"machine: Rays cast again have grids of up to {finest.azimuths} x {finest.polars}, which "
                             f"need an icu.side_bits of {needed}, not {bits}")
        self._weights = hemisphere.polar_weights
        return super().dense_hemispheres(density, hemisphere, points, frames, surfaces)

    def _finer(self, geometry):
        cast = self._windows(geometry)

        def finer(windows, rays):
            records = [one.record(level) for one, (level, _, _) in zip(windows, rays, strict=True)]
            return [one.hits[row * record.columns + column] for one, record, (_, column, row) in zip(
                cast(records, [ray[1:] for ray in rays]), records, rays, strict=True)]
        return finer

    def _some(self, geometry):
        if self._simulated.config.ctu.subshells:
            # Each cluster casts its section of whole frusta.
            whole = self._machine(geometry)
            return lambda record, number: np.stack(next(iter(whole([record]))))[:, number]
        cast = self._windows(geometry, kind="specular frusta")

        def some(record, number):
            (one,) = cast([record], [np.divmod(number, record.columns)[::-1]])
            return one.hits[number], *(shares(one.total(name), len(number)) for name in ("tested", "steps"))
        return some

    def _windows(self, geometry, kind=None):
        """Function from frusta of the same rays, and columns and rows of rays of each, to their results."""
        config = self._simulated.config
        cells = _Cells(geometry, config, self._cell)

        def cast(records, rays):
            found = []
            # Their hits lie in main memory as if all of their rays were cast.
            together = max(1, self.together // len(records[0])) if records else 1
            for begin in range(0, len(records), together):
                part = slice(begin, begin + together)
                sections = [window_sections(column, row, columns=record.columns, rows=record.rows, config=config)
                            for record, (column, row) in zip(records[part], rays[part], strict=True)]
                request = PhaseRequest(
                    geometry=geometry, table=self._table(cells, records[part], records[:1]), records=records[part],
                    windows=sections, hit_format=HitFormat.IDS)
                found += self._results(request, kind)
            return found
        return cast

    @property
    def ray_kinds(self) -> tuple[str, ...]:
        """The kinds of rays of an image that the machine casts."""
        return ("hemisphere", "gather", "primary", *(("shadow",) if self._simulated.config.icu.shadow_bits else ()))

    @property
    def specular_rays(self) -> int:
        """How many rays of an image it has cast behind mirrors and panes."""
        return self._specular.rays if self._specular else 0

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
        config = self._simulated.config
        if not config.icu.shadow_bits:
            return blocked_by_shelling(geometry, CELL)
        if self._shadow_cells is None or self._shadow_cells.geometry is not geometry:
            self._shadow_cells = _Cells(geometry, config, self._cell)
        cells = self._shadow_cells

        def cast(records: Sequence[ShadowRecord]):
            parts = [record.parts(config.icu.listed_rays) for record in records]
            together = [part for own in parts for part in own]
            found = iter(())
            if together:
                table = self._table(cells, together, together[::len(together) // SAMPLES + 1])
                found = self._results(phase_request(together, geometry, table, config, ratio=RATIO))
            for record, own in zip(records, parts, strict=True):
                blocked, tests, steps = np.zeros(len(record), dtype=bool), np.zeros(len(record), dtype=np.int64), 0
                for part in own:
                    one = next(found)
                    blocked |= one.hits
                    tests[part.listed] = shares(one.total("tested"), len(part.listed))
                    steps += one.total("steps")
                yield blocked, tests, steps
        return cast

    def _machine(self, geometry: PatchGeometry):
        config = self._simulated.config
        cells = _Cells(geometry, config, self._cell)

        def cast(records: Sequence[FrustumRecord]):
            again = self._samples_in(geometry) if self._cell is None else ()
            table = self._table(cells, records, records[:1], again)
            weights = None if records[0].is_screen else self._weights
            request = phase_request(records, geometry, table, config, ratio=RATIO, weights=weights,
                                    hit_format=HitFormat.IDS, sums=weights is not None)
            for record, one in zip(records, self._results(request), strict=True):
                if one.sums is not None and (one.sums != _sums_of(record, one.hits, request)).any():
                    raise RuntimeError("The machine's sums are not those of its hits")
                yield one.hits, *(shares(one.total(name), len(record)) for name in ("tested", "steps"))
        return cast

    def _table(self, cells, records, *samples):
        """The cells for some frusta, which are counted."""
        table = cells.table(*samples)
        self.cells[cells.cell] = self.cells.get(cells.cell, 0) + len(records)
        return table

    def _results(self, request: PhaseRequest, kind: str | None = None) -> Iterator[FrustumResult]:
        """The results of each frustum; ``kind`` names what they count as, by default of `KINDS`."""
        with progress_bar(desc="machine", unit="section", delay=2, leave=False, disable=not self._progress) as bar:
            done = self._simulated.run([request], progress=lambda completed: bar.update(completed - bar.n))
        (frusta,) = done.frusta
        counts = {"frusta": len(frusta), "rays": _rays(request), "cycles": done.cycles.total,
                  "tests": sum(one.total("tested") for one in frusta)}
        self.jobs, self.frusta, self.rays = self.jobs + 1, self.frusta + counts["frusta"], self.rays + counts["rays"]
        self.cycles, self.tested = self.cycles + counts["cycles"], self.tested + counts["tests"]
        totals = self.kinds.setdefault(kind or KINDS[request.records[0].bundle], dict.fromkeys(counts, 0))
        for name, count in counts.items():
            totals[name] += count
        return iter(frusta)


class _Cells:
    """The cells of patches: of the size that is given, or else of the one that is chosen for some frusta."""

    def __init__(self, geometry: PatchGeometry, config: Config, cell: float | None):
        self.geometry, self.cell, self._config = geometry, cell, config
        self._made: CellTable | None = None

    def table(self, first: Sequence[FrustumRecord], again: Sequence[FrustumRecord] = ()) -> CellTable:
        """The cells; their size, unless given, is chosen for ``again`` if there are any, else once for ``first``."""
        samples = again or (first if self.cell is None else ())
        chosen = choose_cell(samples, self.geometry, self._config).cell if samples else self.cell
        if self._made is None or chosen != self.cell:
            self.cell = chosen
            self._made = job_shelling(self.geometry, self._config, cell=chosen).table
        return self._made


def _rays(request):
    """The rays of a request."""
    if request.windows is not None:
        return sum(section.rays for cut in request.windows for section in cut)
    return sum(len(record.listed) if record.bundle == Bundle.SHADOW else len(record) for record in request.records)


def _sums_of(record, patch, request):
    """N int64: of each patch the weights of the rays that hit it."""
    met, sums = np.flatnonzero(patch >= 0), np.zeros(len(request.geometry), dtype=np.int64)
    np.add.at(sums, patch[met], request.weights[met // record.columns])
    return sums
