"""The mutation score: how many small faults in the hardware the testbenches kill."""

import contextlib
import io
import json
import multiprocessing
import time
from pathlib import Path

import click

from golden.progress_bar import progress_bar
from radiosity.benchmarks.report import provenance
from tb.lib.runner import Simulation
from tb.mutation.blocks import BLOCKS, run_of
from tb.mutation.equivalence import is_equivalent
from tb.mutation.mutants import make_mutants


class _Run:
    """Runs a testbench on a mutant, in a process of its own: the mutant's number, and whether it survives."""

    def __init__(self, part, bench, text, seed):
        self._part, self._bench, self._text, self._seed = part, bench, text, seed

    def __call__(self, mutant):
        output = io.StringIO()
        with contextlib.redirect_stderr(output), contextlib.redirect_stdout(output):
            failed = Simulation(self._text).run(
                self._bench.module, self._bench.tests, f"mutants/{self._part}-{mutant}", self._seed,
                self._bench.given, plusargs=(f"+mutant={mutant}",), failures=1)
        return mutant, not failed


def score(block: str, part: str, *, count: int, seed: int, processes: int) -> dict:
    """Mutants of a part of a block: how many, which survive, and which of these are equivalent to the component.

    Raises
    ------
    RuntimeError
        The testbench fails without a mutant.
    """
    bench = run_of(block, part)
    mutants = make_mutants(bench.text, count=count, seed=seed)
    run = _Run(f"{block}-{part.replace(' ', '-')}", bench, mutants.text, seed)
    if not run(0)[1]:
        raise RuntimeError(f"The testbench of {part} fails without a mutant")
    started, survives = time.monotonic(), {}
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        todo = range(1, len(mutants.about) + 1)
        for mutant, survived in progress_bar(pool.imap_unordered(run, todo), total=len(todo), desc=part):
            survives[mutant] = survived
    left = [mutant for mutant in sorted(survives) if survives[mutant]]
    equivalent = [mutant for mutant in left if is_equivalent(mutants, mutant)]
    return {"block": block, "part": part, "seed": seed, "count": len(mutants.about),
            "seconds": time.monotonic() - started, "equivalent": equivalent,
            "survivors": {str(mutant): mutants.about[mutant - 1] for mutant in left if mutant not in equivalent}}


def row(block: str, part: str, found: list[dict]) -> str:
    """A row of the table: the mutants of some parts, and the mutation score of those that are not equivalent."""
    count, equivalent, left = (sum(len(one[name]) if name != "count" else one[name] for one in found)
                               for name in ("count", "equivalent", "survivors"))
    others = count - equivalent
    names = "" if len(found) > 1 else ", ".join(found[0]["survivors"])
    return (f"| {block} | {part} | {count} | {equivalent} | {others} | {others - left} "
            f"| {(others - left) / others:.3f} | {names} |")


@click.command()
@click.argument("blocks", nargs=-1, type=click.Choice(list(BLOCKS)))
@click.option("--count", type=click.IntRange(1), default=200, help="Mutants of each block, divided among its parts.")
@click.option("--seed", type=click.IntRange(0), default=1, help="Seed of the mutants.")
@click.option("--processes", type=click.IntRange(1), default=2, help="Simulations at a time.")
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), default="out/bench/mutation.md",
              help="Write the page to this file.")
def main(blocks, count, seed, processes, output):
    """Score the testbenches of BLOCKS (default: all) and write out/bench/mutation.md."""
    found = [score(block, part, count=-(-count // len(BLOCKS[block])), seed=seed, processes=processes)
             for block in blocks or BLOCKS for part in BLOCKS[block]]
    lines = ["# Mutants", "", f"{provenance('amaranth', 'pyosys', 'cocotb')}; seed {seed}.", "",
             "| block | part | mutants | proved equivalent | others | killed | mutation score | survivors |",
             "|---|---|---|---|---|---|---|---|"]
    for block in blocks or BLOCKS:
        parts = [one for one in found if one["block"] == block]
        lines += [row(block, one["part"], [one]) for one in parts]
        if len(parts) > 1:
            lines.append(row(block, "all", parts))
    output.parent.mkdir(parents=True, exist_ok=True)
    output.with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n")
    output.write_text("\n".join(lines) + "\n")
    click.echo(f"wrote {output}")
