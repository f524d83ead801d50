"""A draw of bugs, and which tests kill each."""

import json
from pathlib import Path

from golden.base.errors import InputError
from tb.bugs.drawing import PACKAGES, Bug, candidates, strata
from tb.bugs.nearness import change_detectors, commit_marks, folder_tests, near_tests, simulated, simulator_marks
from tb.bugs.tree import Tree

__all__ = ["STAGES", "Campaign"]

# In the order in which they run, each with the most CPU seconds; the last two run survivors together.
STAGES = {"near": 120, "folder": 300, "simulators": 300, "commit": 2500, "detectors": 600}
_TOGETHER = ("commit", "detectors")
# Draws of a bug that fail import, elaboration or lint, after which something else must be wrong.
_TRIES = 100
_MOST_FAILURES = 20


class Campaign:
    """Draws bugs and runs tests; what has been done is in a file of JSON lines, and is not done again.

    Parameters
    ----------
    tree
        Where.
    record
        The file.
    seed
        Of the draw.
    count
        Bugs of the whole draw.
    shard, shards
        Those whose number is ``shard`` modulo ``shards`` run.
    tell
        Is called with a line for each result.
    """

    def __init__(self, tree: Tree, record: Path, *, seed: str, count: int, shard: int = 0, shards: int = 1, tell=print):
        self._tree, self._record, self._seed, self._tell = tree, record, seed, tell
        self._root = tree.path
        self._files = {path.relative_to(self._root).as_posix(): path.read_text().count("\n")
                       for package in PACKAGES for path in sorted((self._root / package).rglob("*.py"))}
        self._files = {path: lines for path, lines in self._files.items() if lines}
        self._numbers = range(shard, count, shards)
        self._strata = strata(self._files, count, seed)
        self._bugs: dict[int, Bug] = {}
        self.results: dict[int, dict] = {}
        # CPU seconds of tests without a bug; None of those that fail.
        self._clean: dict[str, float | None] = {}
        for line in record.read_text().splitlines() if record.exists() else ():
            self._take(json.loads(line))

    def run(self, upto: str) -> None:
        """Run the bugs in all stages up to one."""
        stages = list(STAGES)[:list(STAGES).index(upto) + 1]
        for number in self._numbers:
            bug = self._draw(number)
            for stage in (one for one in stages if one not in _TOGETHER):
                if self._is_open(number, stage):
                    self._try(bug, stage)
        for stage in (one for one in stages if one in _TOGETHER):
            self._try_together([number for number in self._numbers if self._is_open(number, stage)], stage)

    def _is_open(self, number, stage):
        done = self.results[number]
        return "killer" not in done and stage not in done["seconds"]

    def _take(self, event):
        """Take a line of the record into account."""
        if "clean" in event:
            self._clean[event["clean"]] = event["seconds"]
            return
        if "path" in event:
            self.results[event["number"]] = {**event, "seconds": {}, "limited": []}
            return
        done = self.results[event["number"]]
        done["seconds"][event["stage"]] = event["seconds"]
        if event["limited"]:
            done["limited"].append(event["stage"])
        if event["killer"]:
            done |= {"killer": event["killer"], "stage": event["stage"]}

    def _note(self, event):
        self._record.parent.mkdir(parents=True, exist_ok=True)
        with self._record.open("a") as file:
            file.write(json.dumps(event) + "\n")
        self._take(event)

    def _draw(self, number):
        """The bug of a number, which has been checked."""
        if number not in self._bugs:
            known, refused = self.results.get(number), []
            self._tree.inject()
            tried = candidates(self._root, self._files, self._strata[number], number, self._seed)
            for bug, _ in zip(tried, range(_TRIES), strict=False):
                if known is not None:
                    if bug.digest != known["digest"]:
                        continue
                else:
                    self._tree.inject(bug)
                    fault = self._tree.fault(bug)
                    self._tree.inject()
                    if fault:
                        refused.append(fault)
                        continue
                    self._note({**bug.record(), "refused": refused})
                self._bugs[number] = bug
                break
            else:
                raise RuntimeError(f"Bugs of {self._strata[number]} that count must be some, not none: {refused[-1:]}")
        return self._bugs[number]

    def _tests(self, bug, stage):
        """Tests of a stage, their marks, and those that do not run."""
        detectors = sorted(change_detectors(self._root))
        bad = [name for name, seconds in self._clean.items() if seconds is None]
        commit = commit_marks(self._root)
        if stage == "near":
            return near_tests(bug.path, self._root), commit, [*bad, *detectors]
        if stage in ("folder", "simulators"):
            tests = [one for one in folder_tests(bug.path, self._root) if one not in detectors]
            if stage == "folder":
                return tests, commit, [*bad, *detectors]
            is_block = any(one.startswith(tuple(simulated(self._root))) for one in tests)
            return tests if is_block else [], simulator_marks(self._root), [*bad, *detectors]
        return (["tb"], commit, [*bad, *detectors]) if stage == "commit" else (detectors, commit, bad)

    def _try(self, bug, stage):
        """Run the tests of a stage until one fails that passes without the bug."""
        spent, killer, ended = 0.0, "", True
        while not killer:
            tests, marks, without = self._tests(bug, stage)
            if not tests:
                break
            self._tree.inject(bug)
            done = self._tree.run(tests, marks=marks, limit=STAGES[stage], without=tuple(without))
            self._tree.inject()
            spent, ended = spent + done.seconds, done.ended
            if not done.failed:
                break
            clean = self._seconds(done.failed[0])
            # Without an end only if the same test alone is far from the limit.
            if clean is not None and (ended or clean < STAGES[stage] / 3):
                killer, ended = done.failed[0], True
            elif not ended:
                break
        self._end(bug.number, stage, killer, spent, not ended)

    def _seconds(self, test):
        """CPU seconds of a test without a bug, or None if it fails."""
        if test not in self._clean:
            self._tree.inject()
            done = self._run([test])
            self._note({"clean": test, "seconds": None if done.failed else done.seconds})
        return self._clean[test]

    def _run(self, tests):
        """Run tests that failed with some bugs; of names that are not there without them the files."""
        try:
            return self._tree.run(tests, limit=STAGES["commit"])
        except InputError:
            return self._tree.run(sorted({test.partition("::")[0] for test in tests}), limit=STAGES["commit"])

    def _end(self, number, stage, killer, seconds, limited=False):
        self._note({"number": number, "stage": stage, "killer": killer, "seconds": round(seconds, 1),
                    "limited": limited})
        bug = self._bugs[number]
        if killer or stage != "simulators" or bug.path.startswith("hw/"):
            what = f"killed by {killer}" if killer else "limit" if limited else "survives"
            self._tell(f"{number} {bug.path}:{bug.line} {bug.rule} {bug.guard}: {stage} {what} ({seconds:.0f} s)")

    def _try_together(self, numbers, stage):
        """Run all bugs of different files at once, then each alone in the tests that failed."""
        while numbers:
            by_file = {self._bugs[number].path: number for number in numbers}
            pool = sorted(by_file.values())
            bugs = {number: self._bugs[number] for number in pool}
            tests, marks, without = self._tests(None, stage)
            self._tree.inject(*bugs.values())
            done = self._tree.run(tests, marks=marks, limit=STAGES[stage], most=_MOST_FAILURES, without=tuple(without))
            failed = [test for test in done.failed if self._seconds(test) is not None]
            seconds, killed = dict.fromkeys(pool, done.seconds / len(pool)), {}
            for number in pool if failed else ():
                self._tree.inject(bugs[number])
                alone = self._run(failed)
                seconds[number] += alone.seconds
                if alone.failed:
                    killed[number] = alone.failed[0]
            self._tree.inject()
            # As many failures as end a run may hide others, and tests that fail without a bug are left out.
            is_whole = len(done.failed) < _MOST_FAILURES and done.ended and len(failed) == len(done.failed)
            for number in pool:
                if number in killed or is_whole or not (killed or len(failed) < len(done.failed)):
                    self._end(number, stage, killed.get(number, ""), seconds[number], not done.ended)
                    numbers = [other for other in numbers if other != number]
