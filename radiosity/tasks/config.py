"""The parameters of the machine, what is derived from them, and the parts that it has."""

import dataclasses
import inspect
import re

from golden.engine.config import PRESETS, Config
from golden.engine.config.parts import parts
from golden.engine.lib.fixed import Format

__all__ = ["about_parameters", "config_report"]


def config_report(preset: str, assignments: tuple[str, ...]) -> tuple[dict, str]:
    """The parameters of a preset with changes, what is derived from them, and the machine's parts: for JSON, and as
    tables.

    Raises
    ------
    InputError
        See `Config.with_parameters`.
    """
    config = PRESETS[preset].with_parameters(assignments)
    parameters, derived = config.parameters(), _derived(config)
    changed = {path for path, value in parameters.items() if value != PRESETS[preset].parameters()[path]}
    about = about_parameters(config)
    width = max(map(len, [*parameters, *derived]))
    lines = [f"{'parameter':{width}} {'value':>9}  what it is ({preset}{'; * changed' if changed else ''})"]
    lines += [f"{path:{width}} {value!s:>9}{'*' if path in changed else ' '} {about[path]}"
              for path, value in parameters.items()]
    lines.append(f"\n{'derived':{width}} {'bits':>4}  {'format':15} what it is")
    for path, entry in derived.items():
        bits, form = (entry["bits"], entry["format"]) if "bits" in entry else ("", entry["value"])
        lines.append(f"{path:{width}} {bits:>4}  {form!s:15} {entry['about']}")
    found = parts(config)
    name, size = (max(len(getattr(part, column)) for part in found) for column in ("name", "size"))
    lines.append(f"\n{'part':{name}}  {'size':{size}}  what it is, or why there is none")
    lines += [f"{part.name:{name}}  {part.size or 'none':{size}}  {part.about}" for part in found]
    return {"preset": preset, "parameters": parameters, "derived": derived, "parts": {
        part.name: {"size": part.size, "about": part.about} for part in found}}, "\n".join(lines)


def _derived(config: Config) -> dict[str, dict]:
    """Everything that is derived from the parameters: formats with their bits, and other values."""
    entries = {}
    groups = {f"{field.name}.": getattr(config, field.name) for field in dataclasses.fields(config)}
    for prefix, group in {"": config, **groups}.items():
        for name, member in inspect.getmembers_static(type(group), lambda member: isinstance(member, property)):
            value, about = getattr(group, name), _plain(inspect.getdoc(member).split("\n\n")[0])
            kind = {"format": str(value), "bits": value.width} if isinstance(value, Format) else {"value": value}
            entries[prefix + name] = {**kind, "about": about}
    return entries


def about_parameters(config: Config) -> dict[str, str]:
    """The text of each parameter in the docstring of its group; parameters that share a text share it here."""
    about = {}
    for field in dataclasses.fields(config):
        text = inspect.getdoc(type(getattr(config, field.name))).partition("----------\n")[2]
        for names, lines in re.findall(r"^([a-z_, ]+)\n((?:    .*\n?)+)", text, re.MULTILINE):
            about |= {f"{field.name}.{name}": _plain(lines) for name in names.split(", ")}
    return about


def _plain(text):
    return " ".join(text.replace("``", "").split())
