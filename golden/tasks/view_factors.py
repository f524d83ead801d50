"""View factors of a scene, written in the requested format."""

import resource
import time
from pathlib import Path

from golden.light.factors.blocks import BlockStore, scene_key
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.files import check_view_factors_output, write_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from golden.light.factors.view_factors import ViewFactors
from golden.plural import counted
from golden.scene.open import open_scene
from golden.scene.refine import refine
from golden.scene.scene import Scene

__all__ = ["ViewFactorTask"]


class ViewFactorTask:
    """The view factors of a scene, from its name to the written file.

    Parameters
    ----------
    scene
        Name of a built-in scene, or path of a file.
    output
        Path of the result, see `golden.light.factors.files.write_view_factors`.
    facets
        Whether each face of a file is one patch, see `golden.scene.load.load_scene`.
    max_edge, max_area
        Patches are cut until none is larger, see `golden.scene.refine.refine`.
    resume
        Whether blocks of an unfinished run are used.
    progress
        Shows a progress bar after two seconds.

    Raises
    ------
    InputError
        The scene, the output or a limit cannot be used.
    """

    def __init__(self, scene: str, output: Path, *, facets: bool = False, max_edge: float | None = None,
                 max_area: float | None = None, resume: bool = False, progress: bool = False):
        self._began = time.perf_counter()
        check_view_factors_output(output)
        self._name, self._output, self._resume, self._progress = scene, output, resume, progress
        opened = open_scene(scene, facets=facets)
        self.scene: Scene = opened if max_edge is None and max_area is None else refine(
            opened, max_edge=max_edge, max_area=max_area).scene

    def run(self, caster, *, method: str, whole: bool = False, **settings) -> tuple[dict, str]:
        """Compute and write; the report as values and as text.

        Parameters
        ----------
        caster
            A caster of frusta in the scene.
        method
            Its name.
        whole
            Whether all rows are cast as one request, not block by block.
        settings
            Those of `HemisphereRows`.
        """
        size = {"block_rows": len(self.scene)} if whole else {}
        rows = HemisphereRows(self.scene, caster, progress=self._progress and whole, **settings, **size)
        key = {"scene": scene_key(self.scene), "method": method, "block_rows": rows.block_rows, **rows.settings}
        store = BlockStore(self._output.with_name(f"{self._output.name}.blocks"), key, resume=self._resume)
        factors = compute_view_factors(rows, store=store, progress=self._progress and not whole)
        write_view_factors(factors, self._output)
        store.remove()
        return self._report(factors, method)

    def _report(self, factors: ViewFactors, method):
        figures = {"patches": len(factors), "entries": factors.F.nnz, "closure": factors.closure,
                   "reciprocity": factors.reciprocity, "error": factors.largest_error,
                   "largest_change": factors.largest_change, "sky_change": factors.sky_change,
                   "seconds": time.perf_counter() - self._began,
                   "peak_memory": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}
        report = {"output": self._output, "scene": self._name, "method": method, **figures}
        lines = [f"{self._output}: {counted(len(factors), 'patch')}, {factors.F.nnz} entries, closure "
                 f"{factors.closure:.1e}, reciprocity {factors.reciprocity:.1e}"]
        if factors.row_sums is not None:
            shares = factors.row_sums / 2**factors.weight_bits
            report |= {"least_share": shares.min(), "greatest_share": shares.max()}
            lines.append(f"hemispheres met a patch in {shares.min():.2%} to {shares.max():.2%}")
        return report, "\n".join(lines)
