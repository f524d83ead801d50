"""Rows of view factors by hemispheres of rays at fixed points."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.cast.casters import CastsFrusta
from golden.cast.density import Density
from golden.light.factors.factor_matrix import CLOSED
from golden.light.factors.join import Estimate
from golden.light.factors.projection import project
from golden.light.factors.view_factors import ViewFactors
from golden.light.form_factors import PatchRows, gauss_points
from golden.scene.scene import Scene

__all__ = ["HemisphereBlock", "HemisphereRows"]


@dataclass(frozen=True, kw_only=True, eq=False)
class HemisphereBlock:
    """Rows of R consecutive patches with E entries.

    Parameters
    ----------
    indptr, columns, values
        R + 1 int, E int and E float64: the CSR matrix of their view factors.
    row_sums, rays
        R x samples int64 each: see `ViewFactors`, and the rays of each hemisphere.
    """

    indptr: np.ndarray
    columns: np.ndarray
    values: np.ndarray
    row_sums: np.ndarray
    rays: np.ndarray


class HemisphereRows:
    """View factors of a scene's patches by hemispheres at fixed points, block by block.

    Parameters
    ----------
    scene, caster, rays, samples, density, progress
        See `golden.light.form_factors.PatchRows`.
    block_rows
        Rows of a block.
    projected
        Whether `join` closes the rows and makes them reciprocal, see `project`. The errors of fixed points are unknown:
        each factor itself stands for its standard error, so that factors move in proportion.

    Members
    -------
    block_rows, jobs
        Rows of a block, and blocks that may be computed at once.
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
    jobs = 1

    def __init__(self, scene: Scene, caster: CastsFrusta, *, rays: tuple[int, int], samples: int = 1,
                 density: Density | None = None, block_rows: int = 64, projected: bool = False,
                 progress: bool = False):
        self._scene = scene
        self._rows = PatchRows(scene, caster, rays=rays, samples=samples, density=density, progress=progress)
        self._shares = gauss_points(scene, samples)[1]
        self._projected, self.block_rows, self._density = projected, block_rows, density
        self.settings = {"rays": f"{rays[0]}x{rays[1]}", "samples": samples, **({"projected": 1} if projected else {}),
                         **({"least_rays": density.least} if density else {})}

    def __len__(self) -> int:
        return len(self._scene)

    def rows(self, first: int, last: int) -> HemisphereBlock:
        """The block of the patches from ``first`` to before ``last``."""
        part, row_sums, rays = self._rows.cast(np.arange(first, last))
        part.sort_indices()
        return HemisphereBlock(indptr=part.indptr, columns=part.indices, values=part.data, row_sums=row_sums,
                               rays=rays)

    def join(self, blocks) -> ViewFactors:
        """The view factors of the blocks of all rows, in their order."""
        count, blocks = len(self), list(blocks)
        parts = [sparse.csr_array((block.values, block.columns, block.indptr), shape=(len(block.indptr) - 1, count))
                 for block in blocks]
        matrix = sparse.csr_array(sparse.vstack(parts))
        names = np.array([material.name for material in self._scene.materials])
        row_sums, bits = np.concatenate([block.row_sums for block in blocks]), self._rows.weight_bits
        sky = np.maximum(1 - (self._shares * row_sums).sum(axis=1) / 2**bits, 0)
        back = np.maximum(1 - matrix.sum(axis=1) - sky, 0)
        measured = {}
        if self._projected:
            estimate, unprojected = self._estimate(matrix, sky, back)
            measured = {"unprojected": unprojected, "unprojected_sky": sky}
            matrix, sky, back = project(estimate, area=self._scene.areas)
        return ViewFactors(F=matrix, sky=sky, back=back, area=self._scene.areas, normal=self._scene.normals,
                           surface=names[self._scene.material], patch=np.arange(count),
                           front=np.ones(count, dtype=bool), row_sums=row_sums, weight_bits=bits,
                           settings=self.settings | self._cast(blocks), **measured)

    def _cast(self, blocks):
        """The rays cast, where their number does not follow from the settings."""
        return {"rays_cast": int(sum(block.rays.sum() for block in blocks))} if self._density else {}

    def _estimate(self, matrix, sky, back):
        """What the projection begins with, and the matrix with an entry wherever either direction has one."""
        area, rays = self._scene.areas, len(self._rows.hemisphere) * self._shares.shape[1]
        row, column = matrix.tocoo().coords
        pattern = sparse.coo_array((np.ones(2 * len(row)), (np.append(row, column), np.append(column, row))),
                                   shape=matrix.shape).tocsr()
        pattern.sort_indices()
        row, column = pattern.tocoo().coords

        def entries(values):
            return sparse.csr_array((values, pattern.indices, pattern.indptr), shape=pattern.shape)

        forth, reverse = (np.asarray(matrix[first, second]).ravel() for first, second in ((row, column), (column, row)))
        exposure = 1 / area[row] + 1 / area[column]
        # The rays of both directions together, see `golden.light.factors.join.join`.
        exchange = (forth + reverse) / exposure
        few = np.sqrt((forth + reverse) * rays + 0.5) / (rays * exposure)
        error = np.maximum(exchange, few) / area[row]
        outside = [np.where(share > CLOSED, np.sqrt(share * (1 - share) * rays + 0.5) / rays, 0.0)
                   for share in (sky, back)]
        return Estimate(F=entries(exchange / area[row]), error=entries(error), sky=sky, back=back,
                        sky_error=outside[0], back_error=outside[1], unseen_error=np.zeros(len(area)),
                        hidden_error=0.0), entries(forth)
