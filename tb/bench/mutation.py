"""Which small mistakes in the hardware its benches find.

``python -m tb.bench.mutation`` makes mutants of each block with Yosys - a connection that is constant, inverted, or
mixed with another one - and runs the block's bench on each; writes out/bench/mutation.md, with the mutants that were
not found. All mutants of a block are in one simulation, and a number chooses. Those that are proved to do what the
block does are counted apart.
"""

import contextlib
import io
import json
import multiprocessing
import time
from pathlib import Path

import click
from tqdm import tqdm

from tb.bench.report import provenance, write_report
from tb.lib.runner import Simulation
from tb.mutation.blocks import BLOCKS, bench_of
from tb.mutation.equivalence import is_equivalent
from tb.mutation.mutants import make_mutants


class _Judge:
    """Runs the bench on a mutant, in processes of their own: its number, and whether it survives."""

    def __init__(self, block, bench, text, seed):
        self._block, self._bench, self._text, self._seed = block, bench, text, seed

    def __call__(self, mutant):
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            failed = Simulation(self._text).run(
                self._bench.module, self._bench.tests, f"mutants/{self._block}-{mutant}", self._seed,
                self._bench.given, plusargs=(f"+mutant={mutant}",), failures=1)
        return mutant, not failed


def judge(block: str, *, count: int, seed: int, processes: int) -> dict:
    """Mutants of a block and what became of them.

    Errors
    ------
    RuntimeError
        The bench fails without a mutant.
    """
    bench = bench_of(block)
    mutants = make_mutants(bench.text, count=count, seed=seed)
    judged = _Judge(block, bench, mutants.text, seed)
    if not judged(0)[1]:
        raise RuntimeError(f"The bench of {block} fails without a mutant")
    started, survives = time.monotonic(), {}
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        todo = range(1, len(mutants.about) + 1)
        for mutant, survived in tqdm(pool.imap_unordered(judged, todo), total=len(todo), desc=block):
            survives[mutant] = survived
    left = [mutant for mutant in sorted(survives) if survives[mutant]]
    equivalent = [mutant for mutant in left if is_equivalent(mutants, mutant)]
    return {"block": block, "seed": seed, "count": len(mutants.about), "seconds": time.monotonic() - started,
            "equivalent": equivalent, "survivors": {str(mutant): mutants.about[mutant - 1] for mutant in left
                                                    if mutant not in equivalent}}


@click.command()
@click.argument("blocks", nargs=-1, type=click.Choice(list(BLOCKS)))
@click.option("--count", type=click.IntRange(1), default=200, help="Mutants of each block.")
@click.option("--seed", type=click.IntRange(0), default=1)
@click.option("--processes", type=click.IntRange(1), default=2)
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), default="out/bench/mutation.md")
def main(blocks, count, seed, processes, output):
    """Write the table."""
    found = [judge(block, count=count, seed=seed, processes=processes) for block in blocks or BLOCKS]
    lines = ["# Mutants", "", f"{provenance('amaranth', 'pyosys', 'cocotb')}; seed {seed}.", "",
             "| block | mutants | the same, proved | others | found by its bench | share | not found |",
             "|---|---|---|---|---|---|---|"]
    for one in found:
        others = one["count"] - len(one["equivalent"])
        killed = others - len(one["survivors"])
        lines.append(f"| {one['block']} | {one['count']} | {len(one['equivalent'])} | {others} | {killed} | "
                     f"{killed / others:.3f} | {', '.join(one['survivors'])} |")
    output.parent.mkdir(parents=True, exist_ok=True)
    output.with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n")
    write_report(output, lines)


if __name__ == "__main__":
    main()
