"""``stimulus``: inputs and expected outputs of a block, in a file."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import STIMULUS_BLOCKS, STIMULUS_SUFFIXES
from radiosity.cli.parameters import ASSIGNMENTS, FILE, PRESET

__all__ = ["export_stimulus"]


@click.command("stimulus", cls=Task, named={"count": "-n", "seed": "--seed"},
               short_help="Write test vectors of a block.", epilog=f"BLOCK is one of {', '.join(STIMULUS_BLOCKS)}.")
@click.argument("block")
@click.option("-n", "count", type=int, default=1000, help="Set the number of vectors.")
@click.option("--seed", type=int, default=0, help="Set the seed of all random choices.")
@PRESET
@ASSIGNMENTS
@click.option("-o", "--output", type=FILE, required=True,
              help=f"Write to this file; its name ends in {' or '.join(STIMULUS_SUFFIXES)}.")
def export_stimulus(block, count, seed, preset, assignments, output):
    """Write inputs and expected outputs of BLOCK, its hard cases first.

    An .npz holds one int64 array for each field, and header, a string of JSON that gives for each field whether it is
    input or output, its format (signed a.b has 1 + a + b bits, b of them behind the point), its shape, and a
    description. A .jsonl holds the same header on its first line, then one JSON object for each vector.
    """
    from golden.base.output import check_outputs
    from golden.engine.config import PRESETS
    from golden.engine.stimulus import stimulus
    from golden.engine.stimulus.files import write_stimulus

    check_outputs(output, suffixes=STIMULUS_SUFFIXES)
    made = stimulus(block, count=count, seed=seed, config=PRESETS[preset].with_parameters(assignments))
    write_stimulus(output, made)
    lines = [f"{output}: {made.header['block']}, {count} vectors: {made.header['about']}"]
    for field in made.header["fields"]:
        shape = "x".join(map(str, field["shape"])) or "1"
        lines.append(f"  {field['role']:6} {field['name']:24} {field['format']:14} {shape:12} {field['about']}")
    console().report({"output": output, "vectors": count, "header": made.header}, "\n".join(lines))
