"""The table of arms that a run with the plugin has entered: ``python -m tb.coverage``."""

import json
import tomllib
from pathlib import Path

import click

from tb.coverage.plugin import OUTPUT
from tb.coverage.table import missing, table

EXCLUDED = Path(__file__).with_name("excluded.toml")


@click.command()
@click.argument("path", type=click.Path(path_type=Path, exists=True, dir_okay=False), default=OUTPUT)
def main(path):
    """Print the table of PATH, which a run with `-p tb.coverage.plugin` writes, and the arms that are missing."""
    run = json.loads(path.read_text())
    excluded = tomllib.loads(EXCLUDED.read_text())
    click.echo(table(run["elaborated"], run["entered"], excluded))
    click.echo("\n".join(["", *missing(run["elaborated"], run["entered"], excluded)]))


if __name__ == "__main__":
    main()
