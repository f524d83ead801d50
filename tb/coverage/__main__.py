"""What a run with the plugin has covered: ``python -m tb.coverage``."""

import json
import sys
import tomllib
from pathlib import Path

import click

from tb.coverage.plugin import OUTPUT
from tb.coverage.table import missing, needless, table

EXCLUDED = Path(__file__).with_name("excluded.toml")


@click.command()
@click.argument("path", type=click.Path(path_type=Path, exists=True, dir_okay=False), default=OUTPUT)
def main(path):
    """Print the table of PATH, which a run with `-p tb.coverage.plugin` writes, and what is missing."""
    run = json.loads(path.read_text())
    excluded = tomllib.loads(EXCLUDED.read_text())
    click.echo(table(run, excluded))
    click.echo("\n".join(["", *missing(run, excluded)]))
    if stale := needless(run, excluded):
        sys.exit(f"error: excluded in {EXCLUDED.name}, but covered or unknown: {', '.join(stale)}")


if __name__ == "__main__":
    main()
