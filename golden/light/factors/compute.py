"""View factors, computed block by block."""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from golden.light.factors.blocks import BlockStore
from golden.light.factors.view_factors import ViewFactors
from golden.progress_bar import progress_bar

__all__ = ["compute_view_factors"]


def compute_view_factors(rows, *, store: BlockStore | None = None, progress: bool = False) -> ViewFactors:
    """The view factors of all rows.

    Parameters
    ----------
    rows
        What computes blocks, ``jobs`` at once, and joins them, such as `golden.light.factors.rows.FactorRows`.
    store
        Where finished blocks are kept. Default: nowhere.
    progress
        Shows a progress bar with the time left after two seconds.
    """
    size = rows.block_rows

    def block_from(first):
        block = store.load(first, rows.kind) if store else None
        if block is None:
            block = rows.rows(first, min(first + size, len(rows)))
            # The work of a single block ends with the output itself.
            if store and len(rows) > size:
                store.save(first, block)
        return block

    blocks = []
    with progress_bar(total=len(rows), desc="view factors", unit="row", delay=2, disable=not progress) as bar:
        for block in _in_order(block_from, range(0, len(rows), size), rows.jobs):
            blocks.append(block)
            bar.update(min(size, len(rows) - bar.n))
    return rows.join(blocks)


def _in_order(function, arguments, jobs) -> Iterator:
    """The results for all arguments, of which ``jobs`` threads compute some in advance."""
    if jobs == 1:
        yield from map(function, arguments)
        return
    with ThreadPoolExecutor(jobs) as threads:
        ahead = deque()
        try:
            for argument in arguments:
                ahead.append(threads.submit(function, argument))
                # A few blocks of rows that take long must not stop the other threads.
                if len(ahead) > 4 * jobs:
                    yield ahead.popleft().result()
            while ahead:
                yield ahead.popleft().result()
        finally:
            for future in ahead:
                future.cancel()
