"""The nightly in shards, its ledger, and releases: ``python -m tb.runs``."""

from pathlib import Path
from random import SystemRandom

import click

from tb.runs.inputs import Inputs
from tb.runs.ledger import LEDGER, Ledger
from tb.runs.nightly import run_shards
from tb.runs.release import NotReadyError, release
from tb.runs.shard import shards

ROOT = Path(__file__).parents[2]


@click.group()
@click.option("--ledger", type=click.Path(path_type=Path, dir_okay=False), default=ROOT / LEDGER,
              help="Keep the ledger in this file.")
@click.pass_context
def main(context, ledger):
    """Run the nightly in shards, and release what passed."""
    try:
        context.obj = Ledger(ledger)
    except ValueError as error:
        raise click.ClickException(str(error)) from error


@main.command()
@click.argument("names", nargs=-1)
@click.option("--seed", type=click.IntRange(0, 2**32 - 1), help="Draw from this; default: a random one.")
@click.option("--minutes", type=float, help="Begin no shard later than this.")
@click.pass_obj
def nightly(ledger, names, seed, minutes):
    """Run the shards NAMES, or all that are not green in the ledger for this commit."""
    by_name = {shard.name: shard for shard in shards(ROOT / "tb")}
    if unknown := [name for name in names if name not in by_name]:
        raise click.ClickException(f"no shard {unknown[0]}; there are {', '.join(by_name)}")
    seed = SystemRandom().randrange(2**32) if seed is None else seed
    todo = [by_name[name] for name in names or ledger.missing(by_name, Inputs(ROOT, by_name.values()).digest)]
    click.echo(f"== {len(todo)} of {len(by_name)} shards; again: SEED={seed} make nightly")
    is_green = run_shards(ROOT, todo, ledger, seed=seed, minutes=minutes, report=lambda entry: click.echo(
        f"== {entry.shard}: {entry.result}, {entry.passed} passed, {entry.failed} failed, {entry.wall / 60:.1f} min"))
    if not is_green:
        raise click.ClickException("not all shards are green: python -m tb.runs status")


@main.command()
@click.pass_obj
def status(ledger):
    """Print what the ledger says of this commit."""
    parts = shards(ROOT / "tb")
    click.echo(ledger.table([shard.name for shard in parts], Inputs(ROOT, parts).digest))


@main.command(name="release")
@click.pass_obj
def tag(ledger):
    """Tag this commit if everything passes in a clean clone and the ledger is complete."""
    try:
        click.echo(f"tagged {release(ROOT, ledger, report=click.echo)}")
    except NotReadyError as error:
        raise click.ClickException(str(error)) from error


if __name__ == "__main__":
    main()
