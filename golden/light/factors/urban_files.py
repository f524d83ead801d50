"""View factors as the text files of urban-climate models: vfsparse.inp, svf.inp and facetarea.inp."""

from contextlib import ExitStack
from pathlib import Path

import numpy as np

from golden.base.output import whole_file
from golden.light.factors.factor_matrix import FactorMatrix

__all__ = ["URBAN", "urban_paths", "write_urban"]

URBAN = "vfsparse.inp"
# Lines that are formatted at once.
_LINES = 1 << 16


def urban_paths(path: Path) -> tuple[Path, Path, Path]:
    """The files of the matrix, the sky view factors and the areas; an ending such as ``.065`` is that of ``path``."""
    ending = path.name[len(URBAN):]
    return path, path.with_name(f"svf.inp{ending}"), path.with_name(f"facetarea.inp{ending}")


def write_urban(factors: FactorMatrix, path: Path) -> None:
    """Write ``vfsparse.inp`` (lines ``i j F``, patches from 1), and beside it ``svf.inp`` and ``facetarea.inp``.

    Numbers have 10 digits. Zeros are left out; the number of lines is the model's ``nnz``. No file is replaced before
    all three are written.
    """
    matrix = factors.F.tocoo()
    chosen = matrix.data > 0
    row, column, value = matrix.row[chosen] + 1, matrix.col[chosen] + 1, matrix.data[chosen]
    with ExitStack() as files:
        entries, sky, area = (files.enter_context(whole_file(one)) for one in urban_paths(path))
        columns = (sky, "# sky view factors", factors.sky), (area, "# area of facets", factors.area)
        for part, header, values in columns:
            np.savetxt(part, values, fmt="%.10g", header=header, comments="")
        with entries.open("w", encoding="ascii") as file:
            for first in range(0, len(value), _LINES):
                some = slice(first, first + _LINES)
                file.writelines(f"{i} {j} {share:.10g}\n" for i, j, share in
                                zip(row[some].tolist(), column[some].tolist(), value[some].tolist(), strict=True))
