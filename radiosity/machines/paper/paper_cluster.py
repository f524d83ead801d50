"""Paper cluster: the events of a cluster that casts its section of one frustum after the other."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from radiosity.machines.paper.agenda import Agenda
from radiosity.machines.paper.cluster_memory import ClusterMemory
from radiosity.machines.paper.paper_timing import PaperTiming
from radiosity.machines.paper.section_work import SectionWork

__all__ = ["ClusterCounts", "PaperCluster"]


@dataclass(kw_only=True)
class ClusterCounts:
    """Counts of a cluster in a step.

    Parameters
    ----------
    tests, steps, patches, skipped
        Intersection tests, steps of the traversal units, references to patches, and patches found that are not referred
        to, since their tags name other clusters.
    deferred, most_deferred
        Rays, each with a patch, that have been deferred; and those at the same time, at most.
    parked
        Rays that the deferred-ray memory had no free entry for: they are checked a second time.
    ends
        When each frustum ends.
    """

    tests: int = 0
    steps: int = 0
    patches: int = 0
    skipped: int = 0
    deferred: int = 0
    most_deferred: int = 0
    parked: int = 0
    ends: list[int]


class PaperCluster:
    """Traversal units and an intersection unit, as servers.

    A traversal unit takes the subshells of its sector in order. A subshell begins when its rays have left the shell
    before, and when the shell before that one has ended everywhere in the section: its windows size the subshell. The
    patch that a subshell finds is tested against the rays of its window whose presence bit is full: their subshell has
    been permitted to begin. The other ones are deferred until it is.

    Parameters
    ----------
    agenda, timing
        The simulation, and latencies.
    memory
        Where patches are referred to.
    works, rays
        The section's work for each frustum, and its rays, which are read out in between.
    begin
        When the first frustum begins.

    Members
    -------
    counts
        What has been counted.
    """

    def __init__(self, agenda: Agenda, timing: PaperTiming, memory: ClusterMemory, *, works: Sequence[SectionWork],
                 rays: int, begin: int):
        self._agenda, self._timing, self._memory, self._works = agenda, timing, memory, works
        self._rays, self.counts = rays, ClusterCounts(ends=[])
        agenda.at(begin, self._begin)

    def _begin(self):
        """Begin the next frustum, all of whose units are idle."""
        work = self._works[len(self.counts.ends)]
        self._subshells = subshells = work.subshells
        self._unmet = [len(one.needs) + (one.shell > 2) for one in subshells]
        self._dependents = [[] for _ in subshells]
        self._of_shell, self._queues = defaultdict(list), defaultdict(list)
        for number, one in enumerate(subshells):
            self._of_shell[one.shell].append(number)
            self._queues[one.sector].append(number)
            for needed in one.needs:
                self._dependents[needed].append(number)
        self._left_in_shell = {shell: len(numbers) for shell, numbers in self._of_shell.items()}
        # Traversal units take the last one of the list.
        for queue in self._queues.values():
            queue.reverse()
        self._is_present, self._is_listed = [False] * len(subshells), [False] * len(subshells)
        self._is_complete = [False] * len(subshells)
        self._unchecked, self._tests = [len(one.patches) for one in subshells], [0] * len(subshells)
        self._left, self._open_tests, self._is_busy = len(subshells), 0, set()
        # When servers are free; rays that are deferred or parked, by subshell.
        self._lists = self._setup = self._check = self._test = self._agenda.now
        self._deferred, self._parked, self._entries = defaultdict(list), defaultdict(list), 0
        self.counts.tests += work.tests
        self.counts.steps += work.steps
        for number in self._of_shell[1]:
            self._permit(number)

    def _permit(self, number):
        """The rays of a subshell have left the shell before: their presence bits are full."""
        self._is_present[number] = True
        for rays in self._deferred.pop(number, ()):
            self._entries -= rays
            self._send_tests(number, rays, behind=True)
        for rays in self._parked.pop(number, ()):
            self._check = max(self._agenda.now, self._check) + rays
            self._agenda.at(self._check, self._send_tests, number, rays)
        self._traverse(self._subshells[number].sector)

    def _traverse(self, sector):
        """The traversal unit of a sector begins its next subshell, if it is idle and the subshell is permitted."""
        queue = self._queues[sector]
        if sector in self._is_busy or not queue or not self._is_present[queue[-1]]:
            return
        number = queue.pop()
        one, now = self._subshells[number], self._agenda.now
        cycles, latency = max(one.scanned, one.steps, 1), self._timing.traversal
        self._is_busy.add(sector)
        for index, patch in enumerate(one.patches):
            # Cells leave evenly; a list is read an entry a cycle.
            met = now + latency + -(-cycles * (index + 1) // len(one.patches))
            self._lists = max(met, self._lists + patch.entries)
            self._agenda.at(self._lists, self._refer, number, patch)
        self._lists += one.entries
        self._agenda.at(now + cycles, self._end_traversal, sector)
        self._agenda.at(max(now + cycles + latency, self._lists), self._end_lists, number)

    def _end_traversal(self, sector):
        self._is_busy.discard(sector)
        self._traverse(sector)

    def _end_lists(self, number):
        self._is_listed[number] = True
        self._complete(number)

    def _refer(self, number, patch):
        if self._memory.names(patch.patch):
            self.counts.patches += 1
            self._memory.refer(patch.patch, self._set_up, number, patch)
            return
        if patch.tests:
            raise RuntimeError(f"Patch {patch.patch} has tests in a section that its tag does not name")
        self.counts.skipped += 1
        self._unchecked[number] -= 1
        self._complete(number)

    def _set_up(self, number, patch):
        """A patch can be read: it is transformed, and its window computed."""
        begin = max(self._agenda.now, self._setup)
        self._setup = begin + self._timing.vertices
        self._agenda.at(self._setup + self._timing.setup, self._check_rays, number, patch)

    def _check_rays(self, number, patch):
        """The rays of a window are checked one after the other."""
        self._check = max(self._agenda.now, self._check) + max(1, patch.rays)
        self._agenda.at(self._check, self._end_check, number, patch)

    def _end_check(self, number, patch):
        for where, rays in patch.tests:
            self._tests[where] += 1
            self._open_tests += 1
            if self._is_present[where]:
                self._send_tests(where, rays)
            elif self._entries + rays <= self._timing.deferred:
                self._deferred[where].append(rays)
                self._entries += rays
                self.counts.deferred += rays
                self.counts.most_deferred = max(self.counts.most_deferred, self._entries)
            else:
                self._parked[where].append(rays)
                self.counts.parked += rays
        self._unchecked[number] -= 1
        self._complete(number)

    def _send_tests(self, number, rays, behind=False):
        """Tests of rays that have been checked during the last cycles, or that follow ``behind`` this one."""
        self._test = max(self._agenda.now + rays * behind, self._test + rays)
        self._agenda.at(self._test + self._timing.pipeline, self._end_tests, number)

    def _end_tests(self, number):
        self._tests[number] -= 1
        self._open_tests -= 1
        self._complete(number)

    def _complete(self, number):
        """Complete a subshell with nothing in flight, and what follows from it."""
        if (self._is_listed[number] and not self._is_complete[number] and not self._unchecked[number]
                and not self._tests[number]):
            self._is_complete[number] = True
            self._left -= 1
            shell = self._subshells[number].shell
            self._left_in_shell[shell] -= 1
            self._meet(self._dependents[number])
            if not self._left_in_shell[shell]:
                self._meet(self._of_shell[shell + 2])
        if not self._left and not self._open_tests:
            self._end()

    def _meet(self, numbers):
        for number in numbers:
            self._unmet[number] -= 1
            if not self._unmet[number]:
                self._permit(number)

    def _end(self):
        """The frustum has been cast: the collector reads its rays."""
        self.counts.ends.append(self._agenda.now)
        self._left = -1
        if len(self.counts.ends) < len(self._works):
            self._agenda.at(self._agenda.now + self._rays, self._begin)
