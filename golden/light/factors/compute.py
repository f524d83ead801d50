"""View factors, computed block by block."""

from golden.light.factors.blocks import BlockStore
from golden.light.factors.view_factors import ViewFactors
from golden.progress_bar import progress_bar

__all__ = ["compute_view_factors"]


def compute_view_factors(rows, *, store: BlockStore | None = None, progress: bool = False) -> ViewFactors:
    """The view factors of all rows.

    Parameters
    ----------
    rows
        What computes blocks and joins them, such as `golden.light.factors.hemisphere_rows.HemisphereRows`.
    store
        Where finished blocks are kept. Default: nowhere.
    progress
        Shows a progress bar with the time left after two seconds.
    """
    blocks, size = [], rows.block_rows
    with progress_bar(total=len(rows), desc="view factors", unit="row", delay=2, disable=not progress) as bar:
        for first in range(0, len(rows), size):
            last = min(first + size, len(rows))
            block = store.load(first, rows.kind) if store else None
            if block is None:
                block = rows.rows(first, last)
                # The work of a single block ends with the output itself.
                if store and len(rows) > size:
                    store.save(first, block)
            blocks.append(block)
            bar.update(last - first)
    return rows.join(blocks)
