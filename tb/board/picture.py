"""``python -m tb.board.picture FILE``: the picture among the bytes that a board has sent."""

from pathlib import Path

import click

from golden.base.errors import InputError
from golden.light.image import write_png
from radiosity.flow.host import EngineError
from tb.board.decoder import frames, hit_picture, results

__all__ = ["main"]


@click.command()
@click.argument("file", type=click.File("rb"))
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), default="hits.png",
              show_default=True)
def main(file, output) -> None:
    """Write the picture of the last cast in FILE."""
    try:
        cast = results(frames(file.read()))
    except (EngineError, InputError) as error:
        raise click.ClickException(str(error)) from error
    write_png(output, hit_picture(cast))
    patch = cast.hits.patch
    click.echo(f"{output}: {len(patch)} rays, {int((patch >= 0).sum())} hits, {cast.cycles} cycles")


if __name__ == "__main__":
    main()
