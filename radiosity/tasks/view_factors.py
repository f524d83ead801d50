"""View factors of a scene, written in the requested format."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from golden.base.output import check_inputs_stay, check_named_once, check_outputs, whole_file
from golden.base.peak_memory import peak_memory
from golden.base.plural import counted
from golden.base.spread import Spread
from golden.light.factors.blocks import BlockStore, scene_key
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.csv_file import write_receivers
from golden.light.factors.files import (
    SURFACE_SUFFIXES,
    check_view_factors_output,
    write_by_surface,
    write_view_factors,
)
from golden.light.factors.groups import grouped
from golden.light.factors.periodic import PeriodicRows, tiled
from golden.light.factors.receivers import receiver_factors
from golden.light.factors.rows import FactorRows
from golden.light.factors.truncation import truncated
from golden.light.factors.units import METRES, in_metres
from golden.light.factors.view_factors import ViewFactors
from golden.light.photometry.sensor_file import read_sensors
from golden.scene.load import FACETED
from golden.scene.open import open_scene
from golden.scene.overlaps import warn_of_overlaps
from golden.scene.refine import refine
from golden.scene.scene import Scene
from golden.scene.zenith import warn_of_upright_floors, zenith_line

__all__ = ["ViewFactorTask"]

# Ratio of the errors of successive attempts within a time limit, the first attempt's error, and the most by which an
# attempt takes longer than the one before.
_FINER, _COARSEST, _LONGER = 4, 0.05, 8


class ViewFactorTask:
    """The view factors of a scene, from its name to the written file.

    Parameters
    ----------
    scene
        Name of a built-in scene, or path of a file.
    output
        Path of the result, see `golden.light.factors.files.write_view_factors`.
    zenith
        The scene's up, see `golden.scene.open.open_scene`.
    has_sky_patches
        Whether shares of patches of the sky are requested, for which the scene's up matters.
    surfaces
        Path of the view factors between surfaces (.csv, .nc or .npz), or None.
    receivers
        Path of points (`read_sensors`), and of the table of their view factors (.csv); or None.
    period
        Distances after which the scene repeats (`golden.light.factors.periodic.tiled`), or None: it does not.
    drop_below
        The factors of ``output`` are `truncated` below this, or None. Those between surfaces are of all.
    facets
        Whether each face of a file is one row, see `golden.scene.load.load_scene`; where patches are cut by size, only
        their parts are.
    unit
        The scene's unit of length, see `golden.light.factors.units.METRES`.
    max_edge, max_area
        Patches are cut until none is larger, see `golden.scene.refine.refine`.
    progress
        Shows a progress bar after two seconds.

    Members
    -------
    scene
        What rays meet: the scene, with its copies if it repeats.

    Raises
    ------
    InputError
        The scene, the output or a limit cannot be used.

    Warns
    -----
    InputWarning
        Patches overlap in one plane, or floors stand upright where the scene's up matters.
    """

    def __init__(self, scene: str, output: Path, *, zenith=None, has_sky_patches: bool = False,
                 surfaces: Path | None = None, receivers: tuple[Path, Path] | None = None,
                 period: tuple[float, float] | None = None, drop_below: float | None = None, facets: bool = False,
                 unit: str = "m", max_edge: float | None = None, max_area: float | None = None,
                 progress: bool = False):
        self._began = time.perf_counter()
        check_view_factors_output(output)
        check_outputs(surfaces, suffixes=SURFACE_SUFFIXES)
        points, self._table = receivers or (None, None)
        check_outputs(self._table, suffixes=(".csv",))
        check_named_once(output, surfaces, self._table)
        check_inputs_stay(*filter(None, [points]), outputs=(output, surfaces, self._table))
        self._points = read_sensors(points) if points else None
        self._name, self._output, self._surfaces = scene, output, surfaces
        self._progress, self._unit, self._drop_below = progress, unit, drop_below
        opened = open_scene(scene, zenith=zenith, facets=facets)
        has_up = has_sky_patches or period is not None
        self._zenith = zenith_line(scene, opened, is_given=zenith is not None) if has_up else None
        if has_up and zenith is None:
            warn_of_upright_floors(opened)
        is_cut = max_edge is not None or max_area is not None
        self._facet = opened.surface if facets and not is_cut and Path(scene).suffix.lower() in FACETED else None
        warn_of_overlaps(opened, number=self._facet)
        self._own = refine(opened, max_edge=max_edge, max_area=max_area).scene if is_cut else opened
        self._period = period
        self.scene: Scene = tiled(self._own, period) if period else self._own

    def rows(self, caster, **options) -> FactorRows:
        """The rows of the scene, for a caster of `scene`; options are those of `FactorRows`."""
        if self._period:
            return PeriodicRows(self._own, self._period, self.scene, caster, **options)
        return FactorRows(self.scene, caster, **options)

    def store(self, rows, *, method: str, resume: bool) -> BlockStore:
        """Where finished blocks of rows are kept; to be made before the work starts.

        Raises
        ------
        InputError
            The folder has blocks of other work, or blocks although ``resume`` is false.
        """
        key = {"scene": scene_key(self.scene), "method": method, "block_rows": rows.block_rows, **rows.settings}
        return BlockStore(self._output.with_name(f"{self._output.name}.blocks"), key, resume=resume)

    def run(self, rows, store: BlockStore, *, method: str, spread: Spread | None = None) -> tuple[dict, str]:
        """Compute and write; the report as values and as text.

        Parameters
        ----------
        rows
            What computes blocks and joins them, see `compute_view_factors`.
        store
            Where finished blocks are kept.
        method
            How rays are cast.
        spread
            What computes the blocks, see `compute_view_factors`.
        """
        factors = compute_view_factors(rows, store=store, spread=spread,
                                       progress=self._progress and len(rows) > rows.block_rows)
        report = self._written(factors, method)
        store.remove()
        return report

    def run_within(self, limit: float, rows_of: Callable, *, error: float, method: str,
                   spread: Spread | None = None) -> tuple[dict, str]:
        """Compute with smaller and smaller errors, write the last result that the time allows, and report as `run`.

        Parameters
        ----------
        limit
            Seconds; the first attempt, with a coarse error, ends in any case.
        rows_of
            Function from an error to rows.
        error
            The requested error, that of the last attempt.
        method, spread
            See `run`.
        """
        reached, ends = max(error, _COARSEST), self._began + limit
        while True:
            began = time.perf_counter()
            factors = compute_view_factors(rows_of(reached), spread=spread, progress=self._progress)
            now = time.perf_counter()
            if reached == error or now + _LONGER * (now - began) > ends:
                break
            reached = max(error, reached / _FINER)
        report, text = self._written(factors, method)
        if reached > error:
            text += f"\nthe time limit ended the work at an error of {reached:g}"
        return report, text

    def receive(self, caster, *, error: float, seed: int) -> tuple[dict, str]:
        """Compute and write the view factors of the receivers; the report as values and as text, empty without them.

        The caster casts any rays; for the other parameters see `receiver_factors`.
        """
        if self._points is None:
            return {}, ""
        found = receiver_factors(self.scene, caster, self._points, error=error, seed=seed)
        with whole_file(self._table) as part:
            write_receivers(found, part)
        figures = {"receivers": len(self._points), "receivers_output": self._table,
                   "receivers_error": 2 * float(found.error.max())}
        return figures, (f"\n{self._table}: {counted(len(self._points), 'receiver')}, "
                         f"estimated error {figures['receivers_error']:.1e}")

    def _written(self, factors: ViewFactors, method):
        """Write the factors, and report them."""
        if self._facet is not None and len(np.unique(self._facet)) < len(self._facet):
            factors = grouped(factors, self._facet)
        factors = in_metres(factors, self._unit)
        count = write_by_surface(factors, self._surfaces) if self._surfaces else None
        written = truncated(factors, self._drop_below) if self._drop_below else factors
        write_view_factors(written, self._output)
        report, text = self._report(factors, method)
        if self._drop_below:
            dropped = float(written.F.diagonal().max())
            report |= {"entries": written.F.nnz, "largest_dropped": dropped, "largest_absent": written.largest_absent}
            text += (f"\nof these entries, those below {self._drop_below:g} went to the diagonal, up to {dropped:.3g} "
                     f"of a row: {written.F.nnz} are left")
            if written.error is not None:
                text += f", and a factor that is not may be up to {written.largest_absent:.1e}"
        if self._surfaces:
            report |= {"surfaces": count, "surfaces_output": self._surfaces}
            text += (f"\n{self._surfaces}: {counted(count, 'surface')}"
                     f"{'' if count > 1 else ', as surfaces are named by materials, and there is one'}")
        return report, text

    def _report(self, factors: ViewFactors, method):
        figures = {"patches": len(factors), "entries": factors.F.nnz, "closure": factors.closure,
                   "reciprocity": factors.reciprocity, "error": factors.largest_error,
                   "sky_error": factors.largest_sky_error, "sky_patch_error": factors.largest_sky_patch_error,
                   "largest_absent": factors.largest_absent, "largest_change": factors.largest_change,
                   "sky_change": factors.sky_change, "infeasible": factors.infeasible.tolist(),
                   "missed": factors.missed.tolist(), "sky_missed": factors.sky_missed.tolist(),
                   "back": factors.back.max(), "area": factors.area.sum(),
                   "length": self._own.size * METRES[self._unit],
                   "seconds": time.perf_counter() - self._began, "peak_memory": peak_memory()}
        report = {"output": self._output, "scene": self._name, "method": method, **figures}
        lines = [f"{self._output}: {counted(len(factors), 'patch')}, {factors.F.nnz} entries",
                 f"area {figures['area']:.4g} m2 in a scene {figures['length']:.4g} m long: its unit of length is "
                 f"taken as {self._unit} (--unit)",
                 f"closure {factors.closure:.1e}, reciprocity {factors.reciprocity:.1e}"]
        if self._period:
            tiles = len(self.scene) // len(self._own)
            lines.append(f"the scene repeats: a patch counts with those in all {tiles} tiles; what leaves them counts "
                         "as sky")
        if self._zenith:
            lines.append(self._zenith)
        if factors.error is not None:
            lines.append(f"estimated error {factors.largest_error:.1e}, of the sky {factors.largest_sky_error:.1e}; "
                         f"the projection moves factors by up to {factors.largest_change:.1e}, the sky by up to "
                         f"{factors.sky_change:.1e}")
            if factors.F.nnz < len(factors)**2:
                lines.append("a factor between patches that face each other and that has no entry may be up to "
                             f"{factors.largest_absent:.1e}")
        if factors.sky_patches_error is not None:
            lines.append(f"estimated error of a patch of the sky {factors.largest_sky_patch_error:.1e}")
        if factors.back.any():
            lines.append(f"black backs of one-sided patches take up to {factors.back.max():.3g} of a row"
                         f"{'' if self._output.suffix.lower() in ('.npz', '.nc') else ', which these files leave out'}")
        for what, rows, about in (
                ("do not close within their errors", factors.infeasible,
                 f"their sums are off by up to {factors.closure:.1e}; uncut crossings and overlaps of patches do this, "
                 "and a smaller --error may close them"),
                ("miss the requested error", factors.missed,
                 "they have the most segments that a pair may have, and their errors are in the file; smaller patches "
                 "(--max-edge) have smaller errors"),
                ("miss the requested error of the sky", factors.sky_missed,
                 "they have the most rays that a patch may have, and their errors are in the file")):
            if len(rows):
                lines.append(f"rows that {what}: {len(rows)}, the first {', '.join(map(str, rows[:5].tolist()))}: "
                             f"{about}")
        if "rays_cast" in factors.settings:
            report |= {"rays": factors.settings["rays_cast"]}
            lines.append(f"{report['rays']} rays cast, those included that finer ones replace")
        if factors.row_sums is not None:
            shares = factors.row_sums / 2**factors.weight_bits
            report |= {"least_share": shares.min(), "greatest_share": shares.max()}
            lines.append(f"hemispheres met a patch in {shares.min():.2%} to {shares.max():.2%}")
        return report, "\n".join(lines)
