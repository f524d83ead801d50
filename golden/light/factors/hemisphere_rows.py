"""Rows of view factors by hemispheres of rays at fixed points."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.light.factors.view_factors import ViewFactors
from golden.light.form_factors import PatchRows, gauss_points
from golden.scene.scene import Scene

__all__ = ["HemisphereBlock", "HemisphereRows"]


@dataclass(frozen=True, kw_only=True, eq=False)
class HemisphereBlock:
    """Rows of some patches: ``indptr``, ``columns`` and ``values`` of a CSR matrix, and ``row_sums`` of rays."""

    indptr: np.ndarray
    columns: np.ndarray
    values: np.ndarray
    row_sums: np.ndarray


class HemisphereRows:
    """View factors of a scene's patches by hemispheres at fixed points, block by block.

    Parameters
    ----------
    scene, caster, rays, samples, progress
        See `golden.light.form_factors.PatchRows`.
    block_rows
        Rows of a block.

    Members
    -------
    block_rows
        Rows of a block.
    kind
        The class of blocks.
    settings
        What the values depend on beside the scene and the caster.

    Raises
    ------
    InputError
        Rays or samples out of range.
    """

    kind = HemisphereBlock

    def __init__(self, scene: Scene, caster, *, rays: tuple[int, int], samples: int = 1, block_rows: int = 64,
                 progress: bool = False):
        self._scene = scene
        self._rows = PatchRows(scene, caster, rays=rays, samples=samples, progress=progress)
        self._shares = gauss_points(scene, samples)[1]
        self.block_rows = block_rows
        self.settings = {"rays": f"{rays[0]}x{rays[1]}", "samples": samples}

    def __len__(self) -> int:
        return len(self._scene)

    def rows(self, first: int, last: int) -> HemisphereBlock:
        """The block of the patches from ``first`` to before ``last``."""
        part, row_sums = self._rows.cast(np.arange(first, last))
        part.sort_indices()
        return HemisphereBlock(indptr=part.indptr, columns=part.indices, values=part.data, row_sums=row_sums)

    def join(self, blocks) -> ViewFactors:
        """The view factors of the blocks of all rows, in their order."""
        count, blocks = len(self), list(blocks)
        parts = [sparse.csr_array((block.values, block.columns, block.indptr), shape=(len(block.indptr) - 1, count))
                 for block in blocks]
        matrix = sparse.csr_array(sparse.vstack(parts))
        names = np.array([material.name for material in self._scene.materials])
        row_sums, bits = np.concatenate([block.row_sums for block in blocks]), self._rows.hemisphere.weight_bits
        sky = np.maximum(1 - (self._shares * row_sums).sum(axis=1) / 2**bits, 0)
        back = np.maximum(1 - matrix.sum(axis=1) - sky, 0)
        return ViewFactors(F=matrix, sky=sky, back=back, area=self._scene.areas, normal=self._scene.normals,
                           surface=names[self._scene.material], patch=np.arange(count),
                           front=np.ones(count, dtype=bool), row_sums=row_sums, weight_bits=bits,
                           settings=self.settings)
