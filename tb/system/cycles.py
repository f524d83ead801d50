"""Cycles of a fixed set of jobs: ``python -m tb.system.cycles`` writes tb/system/cycles.json anew, or prints those of
one job.

`tb/system/test_cycles.py` fails where the machine takes more or fewer, so that each change of its speed is seen.
"""

import json
from pathlib import Path

import click

from tb.system.job_machine import CONFIGS, JobMachine, cornell, planned

__all__ = ["BASELINE", "JOBS", "cycles_of"]

BASELINE = Path(__file__).with_name("cycles.json")
# By name: the frusta of `cornell`, and main memory.
JOBS: dict[str, tuple[dict, dict]] = {
    "near memory": ({"points": (5, 1, 2)}, {"latency": 1}),
    "chance": ({"points": (9,)}, {"latency": 5, "spread": 30, "shuffles": True}),
    "small cells": ({"cell": 0.2, "points": (5, 1)}, {"latency": 10}),
    "many rays": ({"points": (5,), "rays": (64, 16)}, {"latency": 10}),
    "screen": ({"pixels": (30, 20)}, {"latency": 10}),
}


def cycles_of(name: str, clusters: int) -> dict[str, int | list[int]]:
    """Of one of `JOBS` on one of `CONFIGS`: from the beginning of the load to the last result, and of each cast.

    Raises
    ------
    AssertionError
        Hits are not brute force's.
    """
    frusta, memory = JOBS[name]
    with JobMachine(planned(clusters, cornell(clusters, **{
            "cell": 0.5, "rays": (32, 8), "sets": "scheduled"} | frusta)), **memory) as machine:
        records = machine.right()
        casts = {machine.job.sections[one["tag"]].frustum: int(one["cycles"]) for one in records if one["tag"]}
    return {"job": int(records["end"].max()) - int(records["begin"].min()), "casts": [casts[k] for k in sorted(casts)]}


@click.command()
@click.argument("name", type=click.Choice(list(JOBS)), required=False)
def main(name: str | None) -> None:
    """Write the baseline, or print the cycles of the job NAME on two clusters."""
    if name is not None:
        found = cycles_of(name, 2)
        click.echo(f"{name}: {found['job']} cycles, of casts {', '.join(map(str, found['casts']))}")
        return
    BASELINE.write_text(json.dumps({
        str(clusters): {name: cycles_of(name, clusters) for name in JOBS} for clusters in CONFIGS}, indent=1) + "\n")
    click.echo(f"wrote {BASELINE}")


if __name__ == "__main__":
    main()
