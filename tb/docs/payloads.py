"""The page on payloads: all layouts of streams, with their fields."""

from collections.abc import Mapping

from amaranth.hdl import Shape
from amaranth.lib.data import Layout

from golden.engine.config import Config
from hw.control.control_formats import ControlFormats
from hw.ctu.ctu_formats import CtuFormats
from hw.formats import Formats
from hw.icu.icu_formats import IcuFormats
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.port.memory_formats import MemoryFormats
from tb.docs.structure import fields_of

__all__ = ["FORMATS", "layouts", "payloads"]

# Classes that hold layouts.
FORMATS = (Formats, IcuFormats, CtuFormats, PathFormats, MemoryFormats, ControlFormats)


def layouts(formats: type, config: Config) -> Mapping[str, Layout]:
    """Layouts by name."""
    made = formats(config)
    properties = {name for name, value in vars(formats).items() if isinstance(value, property)}
    values = {name: getattr(made, name) for name in sorted({*vars(made), *properties}) if not name.startswith("_")}
    inherited = {name for base in formats.__bases__ if base is not object for name in layouts(base, config)}
    return {name: value for name, value in values.items() if isinstance(value, Layout) and name not in inherited}


def payloads(config: Config, preset: str) -> str:
    """The page."""
    lines = ["# Payloads", "", "What goes over the streams: layouts with the bits of their fields, the lowest first, "
             f"as they are with preset `{preset}`. A field of several equal parts has their number in brackets.", ""]
    for formats in FORMATS:
        lines += [f"## {formats.__name__}", "", f"`{formats.__module__.replace('.', '/')}.py`", "",
                  "| layout | bits | fields |", "|---|---|---|"]
        for name, layout in layouts(formats, config).items():
            fields = ", ".join(f"`{field.name}` {field.bits}" for field in fields_of(layout))
            lines.append(f"| `{name}` | {Shape.cast(layout).width} | {fields} |")
        lines.append("")
    return "\n".join(lines)
