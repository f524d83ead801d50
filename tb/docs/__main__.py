"""The documentation as a site: ``python -m tb.docs FOLDER``."""

import logging
from pathlib import Path

import click
from mkdocs.commands.build import build
from mkdocs.config import load_config
from mkdocs.exceptions import Abort

from tb.docs.links import broken_links

ROOT = Path(__file__).parents[2]


@click.command()
@click.argument("folder", type=click.Path(path_type=Path), default=Path("out/site"))
def main(folder):
    """Build the site into FOLDER. A broken link or anchor is an error."""
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    try:
        build(load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder.resolve()), strict=True))
    except Abort as error:
        raise click.ClickException(str(error)) from error
    if broken := broken_links(folder):
        raise click.ClickException("links to nothing:\n" + "\n".join(broken))
    click.echo(folder / "index.html")


if __name__ == "__main__":
    main()
