"""Shared radiosity: form factors and radiosities in pages that nodes write, read and take from each other."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.base.errors import InputError
from golden.light.solvers import RadiositySystem
from golden.light.solvers.iteration import TOLERANCE, Solution, State, iterate
from radiosity.machines.common.assignment import assign
from radiosity.machines.common.collectives import reduction
from radiosity.machines.common.content_hash import content_hash
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.koan.koan_run import check_machine
from radiosity.machines.koan.page_run import Items, run_items
from radiosity.machines.koan.page_state import PageState, References, page_state
from radiosity.machines.koan.page_timing import PageTiming
from radiosity.machines.koan.ray_pages import PageString
from radiosity.machines.koan.scene_pages import ScenePages

__all__ = ["WORD_BYTES", "SharedRadiosity", "simulate_radiosity"]

WORD_BYTES = 8
"""Bytes of a form factor or a radiosity."""

_CHANNELS, _MOST_STEPS = 3, 1000


@dataclass(frozen=True, kw_only=True, eq=False)
class SharedRadiosity:
    """The radiosity of a scene, made by simulated nodes.

    Parameters
    ----------
    factors
        N x N, as the nodes have read them from the pages in the last step.
    solution
        Of Gauss-Jacobi.
    rows, time
        ns of the phase of form factors, and of all.
    counts
        By name of `Count`: N int64 after the phase of form factors, and at the end.
    state
        Pages, links and counts at the end.
    """

    factors: sparse.csr_array
    solution: Solution
    rows: int
    time: int
    counts: tuple[dict[str, np.ndarray], dict[str, np.ndarray]]
    state: PageState

    def report(self) -> dict:
        """Times, counts and hashes, ready for JSON."""
        before, after = ({name: int(each.sum()) for name, each in counts.items()} for counts in self.counts)
        names = ("faults", "fetches", "drops", "invalidations", "recalls", "write_backs")
        return {"nodes": len(self.state.nodes), "seconds": self.time / 1e9, "form_factor_seconds": self.rows / 1e9,
                "steps": self.solution.steps, "form_factors": {name: before[name] for name in names},
                "solution": {name: after[name] - before[name] for name in names},
                "F": content_hash(self.factors.indptr.astype(np.int64), self.factors.indices.astype(np.int64),
                                  self.factors.data),
                "radiosity": content_hash(self.solution.radiosity)}


class _Nodes:
    """Nodes with rows of the matrix in shared pages: rows of doubles, behind the scene; then radiosities."""

    def __init__(self, system: RadiositySystem, layout: ScenePages, *, nodes, frames, timing):
        self.count, self.nodes, self.system = len(system), nodes, system
        self.timing = timing
        self.owned = assign("tiled", self.count, nodes)
        self._words = layout.page_bytes // WORD_BYTES
        self._factors = len(layout)
        self._radiosities = self._factors + -(-self.count * self.count // self._words)
        pages = self._radiosities + -(-self.count * _CHANNELS // self._words)
        self.state = page_state(nodes=nodes, pages=pages, frames=frames, page_bytes=layout.page_bytes, timing=timing,
                                words=self._words)
        self.ends = np.zeros(nodes, dtype=np.int64)
        self.matrix = sparse.csr_array(system.matrix)

    def factors_at(self, rows):
        """Page and word of the form factors that are not 0 in some rows, one after the other."""
        where = np.concatenate([row * self.count + self.matrix.indices[self.matrix.indptr[row]:
                                                                       self.matrix.indptr[row + 1]] for row in rows])
        return self._factors + where // self._words, where % self._words

    def radiosities_at(self, rows):
        """Page and word of the radiosities of some patches, channel by channel of each."""
        where = (rows[:, None] * _CHANNELS + np.arange(_CHANNELS)).ravel()
        return self._radiosities + where // self._words, where % self._words

    def run(self, items, own):
        """Run items, each (ns, pages, words, values, whether it writes), which nodes own by ``own``; what is loaded."""
        sizes = [len(pages) for _, pages, *_ in items]
        pages, word, value, writes = (np.concatenate([np.broadcast_to(item[part], size) for item, size in zip(
            items, sizes, strict=True)]) for part in (1, 2, 3, 4))
        references = References((2 * pages + writes).astype(np.int32), word.astype(np.int64), value.astype(np.float64))
        times = run_items(self.state, Items(
            np.cumsum([0, *sizes]), np.array([item[0] for item in items], dtype=np.int64),
            np.full(len(items), self.timing.access), np.asarray(own, dtype=np.int64)), references, self.ends,
            is_shared=False)
        # A barrier.
        self.ends = run_program(reduction(self.nodes, 1), self.state.cube, times.stops)
        self.ends[:] = self.ends.max()
        return np.split(references.value, np.cumsum(sizes)[:-1])


def simulate_radiosity(system: RadiositySystem, string: PageString, work: np.ndarray, layout: ScenePages, *, nodes: int,
                       frames: int, timing: PageTiming | None = None) -> SharedRadiosity:
    """Simulate the phase of form factors, and a solution by Gauss-Jacobi.

    A node makes the rows of its patches, a share of their sequence, and writes them to shared pages. In a step it reads
    them and all radiosities, waits for the others, writes the radiosities of its patches, and waits again. Rows that
    share a page pass it between their nodes. The source describes this and did not build it; the solver, the double
    words, and the two barriers of a step are ours.

    Parameters
    ----------
    system
        The form factors, rows of golden's, and reflectances, emissions and areas.
    string, work
        References and ns of the hemisphere of each patch.
    layout
        The scene's pages.
    nodes, frames
        N, a power of two up to the patches, and the frames of a node's cache.
    timing
        Of faults and messages.

    Raises
    ------
    InputError
        Nodes or frames are out of range, or the tolerance is not reached.

    Source: Badouel 1991, section 5.
    """
    check_machine(nodes, frames)
    timing = timing or PageTiming()
    machine = _Nodes(system, layout, nodes=nodes, frames=frames, timing=timing)
    matrix, items, own = machine.matrix, [], [0]
    for node in range(nodes):
        for patch in machine.owned.patches(node):
            read = string.page[string.first[patch]:string.first[patch + 1]]
            page, word = machine.factors_at([patch])
            row = matrix.data[matrix.indptr[patch]:matrix.indptr[patch + 1]]
            items.append((work[patch], np.append(read, page), np.append(np.zeros(len(read), dtype=np.int64), word),
                          np.append(np.zeros(len(read)), row), np.repeat([0, 1], [len(read), len(page)])))
        own.append(len(items))
    machine.run(items, own)
    rows, counts, loaded = int(machine.ends.max()), machine.state.counted, [matrix]
    solution = iterate(_sweeps(machine, loaded), tolerance=TOLERANCE, max_steps=_MOST_STEPS)
    if not solution.converged:
        raise InputError(f"koan: Steps must be more than {_MOST_STEPS} for an error below {TOLERANCE!r}, not "
                         f"{_MOST_STEPS}")
    return SharedRadiosity(factors=loaded[0], solution=solution, rows=rows, time=int(machine.ends.max()),
                           counts=(counts, machine.state.counted), state=machine.state)


def _sweeps(machine: _Nodes, loaded: list) -> Iterator[State]:
    """States of Gauss-Jacobi; every value comes from the pages."""
    system, matrix, operation = machine.system, machine.matrix, NodeTiming().operation
    patches = [machine.owned.patches(node) for node in range(machine.nodes)]
    own, values = np.arange(machine.nodes + 1), system.emission
    everyone = machine.radiosities_at(np.arange(machine.count))
    in_factors = [machine.factors_at(one) for one in patches]
    while True:
        # The new radiosities, those of the emission at first.
        machine.run([(0, *machine.radiosities_at(one), values[one].ravel(), 1) for one in patches], own)
        found = machine.run([
            (2 * _CHANNELS * len(page) * operation, np.append(page, everyone[0]), np.append(word, everyone[1]), 0.0, 0)
            for page, word in in_factors], own)
        radiosity, residual, rows = np.empty_like(system.emission), np.empty_like(system.emission), []
        for one, (page, _), each in zip(patches, in_factors, found, strict=True):
            bounds = np.append(0, np.diff(matrix.indptr)[one].cumsum())
            entries = np.concatenate([matrix.indices[matrix.indptr[row]:matrix.indptr[row + 1]] for row in one])
            rows.append(sparse.csr_array((each[:len(page)], entries, bounds), shape=(len(one), machine.count)))
            read = each[len(page):].reshape(-1, _CHANNELS)
            radiosity[one] = read[one]
            residual[one] = system.emission[one] + system.reflectance[one] * (rows[-1] @ read) - read[one]
        loaded[0] = sparse.csr_array(sparse.vstack(rows))
        yield State(radiosity, residual)
        values = radiosity + residual
