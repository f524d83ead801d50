"""``config``: the parameters of the machine and what follows from them."""

import dataclasses
import inspect
import json
import re

import click

from golden.commands.parameters import ASSIGNMENTS
from golden.config import PRESETS, Config
from golden.fixed import Format

__all__ = ["about_parameters", "show_config"]


@click.command("config")
@click.argument("preset", type=click.Choice(list(PRESETS)))
@ASSIGNMENTS
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of tables.")
def show_config(preset, assignments, as_json):
    """Print the parameters of PRESET and the widths and formats derived from them."""
    config = PRESETS[preset].with_parameters(assignments)
    parameters, derived = config.parameters(), _derived(config)
    if as_json:
        click.echo(json.dumps({"preset": preset, "parameters": parameters, "derived": derived}, indent=1))
        return
    changed = {path for path, value in parameters.items() if value != PRESETS[preset].parameters()[path]}
    about = about_parameters(config)
    width = max(map(len, [*parameters, *derived]))
    click.echo(f"{'parameter':{width}} {'value':>9}  what it is ({preset}{'; * changed' if changed else ''})")
    for path, value in parameters.items():
        click.echo(f"{path:{width}} {value!s:>9}{'*' if path in changed else ' '} {about[path]}")
    click.echo(f"\n{'derived':{width}} {'bits':>4}  {'format':15} what it is")
    for path, entry in derived.items():
        bits, form = (entry["bits"], entry["format"]) if "bits" in entry else ("", entry["value"])
        click.echo(f"{path:{width}} {bits:>4}  {form!s:15} {entry['about']}")


def _derived(config: Config) -> dict[str, dict]:
    """Everything that follows from the knobs: formats with their bits, and other values."""
    entries = {}
    groups = {f"{field.name}.": getattr(config, field.name) for field in dataclasses.fields(config)}
    for prefix, group in {"": config, **groups}.items():
        for name, member in inspect.getmembers_static(type(group), lambda member: isinstance(member, property)):
            value, about = getattr(group, name), _plain(inspect.getdoc(member).split("\n\n")[0])
            kind = {"format": str(value), "bits": value.width} if isinstance(value, Format) else {"value": value}
            entries[prefix + name] = {**kind, "about": about}
    return entries


def about_parameters(config: Config) -> dict[str, str]:
    """The text of each knob in the docstring of its group; knobs that share a text share it here."""
    about = {}
    for field in dataclasses.fields(config):
        text = inspect.getdoc(type(getattr(config, field.name))).partition("----------\n")[2]
        for names, lines in re.findall(r"^([a-z_, ]+)\n((?:    .*\n?)+)", text, re.MULTILINE):
            about |= {f"{field.name}.{name}": _plain(lines) for name in names.split(", ")}
    return about


def _plain(text):
    return " ".join(text.replace("``", "").split())
