"""View factors, computed block by block."""

from golden.base.progress_bar import progress_bar
from golden.base.spread import Spread, in_threads, spans
from golden.light.factors.blocks import BlockStore
from golden.light.factors.view_factors import ViewFactors

__all__ = ["compute_view_factors"]


def compute_view_factors(rows, *, store: BlockStore | None = None, spread: Spread | None = None,
                         progress: bool = False) -> ViewFactors:
    """The view factors of all rows.

    Parameters
    ----------
    rows
        What computes blocks and joins them, such as `golden.light.factors.rows.FactorRows`.
    store
        Where finished blocks are kept. Default: nowhere.
    spread
        Computes blocks, and gives each as soon as it is finished. Default: as many threads as ``rows`` has ``jobs``.
    progress
        Shows a progress bar with the time left after two seconds.
    """
    blocks = dict.fromkeys(spans(len(rows), rows.block_rows))
    with progress_bar(total=len(rows), desc="view factors", unit="row", delay=2, disable=not progress) as bar:
        for first, last in blocks if store else ():
            blocks[first, last] = store.load(first, rows.kind)
            bar.update(last - first if blocks[first, last] else 0)
        missing = [span for span, block in blocks.items() if block is None]
        for (first, last), block in (spread or in_threads(rows.jobs))(rows.rows, missing):
            # The work of a single block ends with the output itself.
            if store and len(blocks) > 1:
                store.save(first, block)
            blocks[first, last] = block
            bar.update(last - first)
    return rows.join(blocks.values())
