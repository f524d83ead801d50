"""``scenes`` and ``scene``: the built-in scenes, and any scene as a file for other programs."""

import click

from radiosity.cli.command_line import Task
from radiosity.cli.console import console
from radiosity.cli.golden.choices import EXPORT_SUFFIXES
from radiosity.cli.parameters import FILE, SCENE, SCENE_HELP, ZENITH

__all__ = ["export", "list_scenes"]


@click.command("scenes", cls=Task)
def list_scenes():
    """List the built-in scenes."""
    from golden.scene.builtin import BUILTIN

    rows = [{"name": entry.name, "patches": len(entry.make()), "default": entry.default,
             "sizes": [entry.sizes.start, entry.sizes.stop - 1] if entry.sizes else None, "about": entry.about}
            for entry in BUILTIN.values()]
    lines = [f"{'name':10} {'patches':>7}  {'size':12} what it is"]
    for row in rows:
        size = f"{row['sizes'][0]}-{row['sizes'][1]} ({row['default']})" if row["sizes"] else "-"
        lines.append(f"{row['name']:10} {row['patches']:7}  {size:12} {row['about']}")
    lines.append("\nA size follows a colon, as in tetra:4; the default is in brackets, and the count belongs to it.")
    console().report({"scenes": rows}, "\n".join(lines))


@click.command("scene", cls=Task, named={"zenith": "--zenith"}, epilog=SCENE_HELP)
@SCENE
@click.option("-o", "--output", type=FILE, required=True,
              help=f"Write to this file; its name ends in {', '.join(EXPORT_SUFFIXES)}.")
@ZENITH
def export(scene, output, zenith):
    """Write SCENE to a file that other programs read."""
    from golden.base.output import check_inputs_stay, check_outputs
    from golden.base.plural import counted
    from golden.scene.export import export_scene
    from golden.scene.open import open_scene
    from golden.scene.zenith import warn_of_upright_floors, zenith_line

    check_outputs(output, suffixes=EXPORT_SUFFIXES)
    check_inputs_stay(scene, outputs=(output,))
    opened = open_scene(scene, zenith=zenith)
    if zenith is None:
        warn_of_upright_floors(opened)
    export_scene(opened, output)
    counts = {"patches": len(opened), "materials": len(opened.materials)}
    console().report({"output": output, **counts},
                     f"{output}: {counted(counts['patches'], 'patch')}, {counted(counts['materials'], 'material')}\n"
                     f"{zenith_line(scene, opened, is_given=zenith is not None)}")
