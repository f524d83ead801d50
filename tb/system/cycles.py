"""Cycles of a job: ``python -m tb.system.cycles`` prints those of the README on two clusters."""

import click

from tb.system.job_machine import JobMachine, cornell, planned

__all__ = ["JOBS", "cycles_of"]

# By name: the frusta of `cornell`, and main memory.
JOBS: dict[str, tuple[dict, dict]] = {
    "many rays": ({"points": (5,), "rays": (64, 16)}, {"latency": 10})}


def cycles_of(name: str, clusters: int) -> dict[str, int | list[int]]:
    """Of one of `JOBS`: from the beginning of the load to the last result, and of each cast.

    Raises
    ------
    AssertionError
        Hits are not brute force's.
    """
    frusta, memory = JOBS[name]
    with JobMachine(planned(clusters, cornell(clusters, **{"cell": 0.5, "sets": "scheduled"} | frusta)),
                    **memory) as machine:
        records = machine.right()
        casts = {machine.job.sections[one["tag"]].frustum: int(one["cycles"]) for one in records if one["tag"]}
    return {"job": int(records["end"].max()) - int(records["begin"].min()), "casts": [casts[k] for k in sorted(casts)]}


@click.command()
@click.argument("name", type=click.Choice(list(JOBS)))
def main(name: str) -> None:
    """Print the cycles of the job NAME on two clusters."""
    found = cycles_of(name, 2)
    click.echo(f"{name}: {found['job']} cycles, of casts {', '.join(map(str, found['casts']))}")


if __name__ == "__main__":
    main()
