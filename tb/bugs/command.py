"""The command."""

import subprocess
from pathlib import Path

import click

from tb.bugs.campaign import STAGES, Campaign
from tb.bugs.table import EQUIVALENT, page, read_equivalent
from tb.bugs.tree import Tree

__all__ = ["main"]


def _shard(context, parameter, value):
    number, _, count = value.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise click.BadParameter(f"must be K/N with K from 1 to N, not {value!r}")
    return int(number) - 1, int(count)


@click.command()
@click.option("--count", type=click.IntRange(1), default=20, show_default=True, help="Draw so many bugs.")
@click.option("--seed", help="Draw by this text.  [default: the commit]")
@click.option("--shard", default="1/1", callback=_shard, metavar="K/N", help="Run the K-th of N parts of the draw.")
@click.option("--upto", type=click.Choice(list(STAGES)), default="detectors", show_default=True,
              help="Run no later stages than this one.")
def main(count, seed, shard, upto):
    """Draw bugs in the last commit, and write which tests notice them to out/bugs/.

    What has been run stays in a file there: the same command continues.
    """
    commit = subprocess.run(["git", "rev-parse", "HEAD"], check=True, text=True, capture_output=True).stdout.strip()
    seed = seed or commit
    folder = Path("out") / "bugs" / (commit[:12] if seed == commit else f"{commit[:12]}-{seed}")
    tree = Tree(Path("build") / "bugs" / f"tree-{shard[0] + 1}", commit)
    campaign = Campaign(tree, folder / "results.jsonl", seed=seed, count=count, shard=shard[0], shards=shard[1],
                        tell=click.echo)
    try:
        campaign.run(upto)
    finally:
        tree.inject()
        text = page(campaign.results, read_equivalent(EQUIVALENT.read_text()))
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "table.md").write_text(text)
    click.echo(f"\n{text}\nwrote {folder / 'table.md'}")
