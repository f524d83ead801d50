"""Small programs of nodes that share pages, and the runs of them."""

from types import SimpleNamespace

import numpy as np

from radiosity.machines.koan.page_run import Items, run_items
from radiosity.machines.koan.page_state import References, page_state
from radiosity.machines.koan.page_timing import PageTiming

__all__ = ["QUICK", "drawn_run", "run_programs"]

QUICK = PageTiming(setup=100, word=1, trap=1000, serve=10_000)


def run_programs(programs, *, pages, frames=4, timing=QUICK, is_shared=False, words=4, page_bytes=64, start=None):
    """Run items of nodes.

    Parameters
    ----------
    programs
        Of each node its items: (ns of work, [(page, 1 if it writes, word, value), ...]).
    """
    nodes, flat = len(programs), [item for items in programs for item in items]
    made = [one for _, references in flat for one in references]
    page, writes, word, value = (np.array([one[column] for one in made], dtype=kind)
                                 for column, kind in enumerate((np.int64, np.int64, np.int64, np.float64)))
    state = page_state(nodes=nodes, pages=pages, frames=frames, page_bytes=page_bytes, timing=timing, words=words,
                       log=40 * len(made) + 100)
    references = References((2 * page + writes).astype(np.int32), *((word, value) if words else (word[:0], value[:0])))
    items = Items(np.cumsum([0, *(len(each) for _, each in flat)]),
                  np.array([work for work, _ in flat], dtype=np.int64),  # also where no node has an item
                  np.full(len(flat), timing.access), np.cumsum([0, *map(len, programs)]))
    times = run_items(state, items, references, np.zeros(nodes) if start is None else np.array(start),
                      is_shared=is_shared)
    assert state.logged[0] <= len(state.log)
    return SimpleNamespace(state=state, times=times, references=references, log=state.log[:state.logged[0]].tolist(),
                           counts=state.counted,
                           is_write=writes, page=page, word=word)


def drawn_run(seed, *, nodes=4, pages=10, frames=3, writes=0.3, items=10, references=25, **options):
    """Random references of random work; every value that is stored is new."""
    rng = np.random.default_rng(seed)
    number = iter(range(1, 1 << 30))
    programs = [[(int(rng.integers(0, 300_000)),
                  [(int(rng.integers(pages)), int(rng.random() < writes), int(rng.integers(4)), next(number))
                   for _ in range(references)]) for _ in range(items)] for _ in range(nodes)]
    return run_programs(programs, pages=pages, frames=frames, **options)
