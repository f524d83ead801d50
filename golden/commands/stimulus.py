"""``stimulus``: inputs and expected outputs of a block, in a file."""

import click

from golden.commands.parameters import ASSIGNMENTS, FILE, PRESET
from golden.config import PRESETS
from golden.output import check_outputs
from golden.stimulus import BLOCKS, stimulus
from golden.stimulus.files import SUFFIXES, write_stimulus

__all__ = ["export_stimulus"]


@click.command("stimulus", epilog=f"BLOCK is one of {', '.join(BLOCKS)}.")
@click.argument("block")
@click.option("-n", "count", type=int, default=1000, help="Number of vectors.")
@click.option("--seed", type=int, default=0, help="Of all random choices.")
@PRESET
@ASSIGNMENTS
@click.option("-o", "--output", type=FILE, required=True, help=f"File to write: {' '.join(SUFFIXES)}.")
def export_stimulus(block, count, seed, preset, assignments, output):
    """Write inputs and expected outputs of BLOCK, its hard cases first.

    .npz: one int64 array per field, and header, a string of JSON that says of each field whether it is input or output,
    its format (signed a.b has 1 + a + b bits, b of them behind the point), its shape, and what it is. .jsonl: the same
    header on the first line, then one JSON object per vector.
    """
    check_outputs(output, suffixes=SUFFIXES)
    made = stimulus(block, count=count, seed=seed, config=PRESETS[preset].with_parameters(assignments))
    write_stimulus(output, made)
    click.echo(f"{output}: {made.header['block']}, {count} vectors: {made.header['about']}")
    for field in made.header["fields"]:
        shape = "x".join(map(str, field["shape"])) or "1"
        click.echo(f"  {field['role']:6} {field['name']:24} {field['format']:14} {shape:12} {field['about']}")
