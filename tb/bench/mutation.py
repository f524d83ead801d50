"""Which small mistakes in the hardware its benches find.

``python -m tb.bench.mutation`` makes mutants of each block with Yosys - a connection that is constant, inverted, or
mixed with another one - and runs a bench on each; writes out/bench/mutation.md, with the mutants that were not found.
A large block's parts have mutants and benches of their own. All mutants of a part are in one simulation, and a number
chooses. Those that are proved to do what the part does are counted apart.
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
    """Runs a bench on a mutant, in processes of their own: its number, and whether it survives."""

    def __init__(self, part, bench, text, seed):
        self._part, self._bench, self._text, self._seed = part, bench, text, seed

    def __call__(self, mutant):
        said = io.StringIO()
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            failed = Simulation(self._text).run(
                self._bench.module, self._bench.tests, f"mutants/{self._part}-{mutant}", self._seed,
                self._bench.given, plusargs=(f"+mutant={mutant}",), failures=1)
        return mutant, not failed


def judge(block: str, part: str, *, count: int, seed: int, processes: int) -> dict:
    """Mutants of a part of a block and what became of them.

    Errors
    ------
    RuntimeError
        The bench fails without a mutant.
    """
    bench = bench_of(block, part)
    mutants = make_mutants(bench.text, count=count, seed=seed)
    judged = _Judge(f"{block}-{part.replace(' ', '-')}", bench, mutants.text, seed)
    if not judged(0)[1]:
        raise RuntimeError(f"The bench of {part} fails without a mutant")
    started, survives = time.monotonic(), {}
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        todo = range(1, len(mutants.about) + 1)
        for mutant, survived in tqdm(pool.imap_unordered(judged, todo), total=len(todo), desc=part):
            survives[mutant] = survived
    left = [mutant for mutant in sorted(survives) if survives[mutant]]
    equivalent = [mutant for mutant in left if is_equivalent(mutants, mutant)]
    return {"block": block, "part": part, "seed": seed, "count": len(mutants.about),
            "seconds": time.monotonic() - started, "equivalent": equivalent,
            "survivors": {str(mutant): mutants.about[mutant - 1] for mutant in left if mutant not in equivalent}}


def row(block: str, part: str, found: list[dict]) -> str:
    """Of a table: what became of the mutants of some parts."""
    count, equivalent, left = (sum(len(one[name]) if name != "count" else one[name] for one in found)
                               for name in ("count", "equivalent", "survivors"))
    others = count - equivalent
    names = "" if len(found) > 1 else ", ".join(found[0]["survivors"])
    return (f"| {block} | {part} | {count} | {equivalent} | {others} | {others - left} "
            f"| {(others - left) / others:.3f} | {names} |")


@click.command()
@click.argument("blocks", nargs=-1, type=click.Choice(list(BLOCKS)))
@click.option("--count", type=click.IntRange(1), default=200, help="Mutants of each block, as many of each part.")
@click.option("--seed", type=click.IntRange(0), default=1)
@click.option("--processes", type=click.IntRange(1), default=2)
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), default="out/bench/mutation.md")
def main(blocks, count, seed, processes, output):
    """Write the table."""
    found = [judge(block, part, count=-(-count // len(BLOCKS[block])), seed=seed, processes=processes)
             for block in blocks or BLOCKS for part in BLOCKS[block]]
    lines = ["# Mutants", "", f"{provenance('amaranth', 'pyosys', 'cocotb')}; seed {seed}.", "",
             "| block | part | mutants | the same, proved | others | found by its bench | share | not found |",
             "|---|---|---|---|---|---|---|---|"]
    for block in blocks or BLOCKS:
        parts = [one for one in found if one["block"] == block]
        lines += [row(block, one["part"], [one]) for one in parts]
        if len(parts) > 1:
            lines.append(row(block, "all", parts))
    output.parent.mkdir(parents=True, exist_ok=True)
    output.with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n")
    write_report(output, lines)


if __name__ == "__main__":
    main()
