"""Pages on components: what their docstrings say, and what they are made of."""

import inspect
import re
from collections import Counter
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path

from tb.docs.diagram import dot, draw
from tb.docs.payloads import FORMATS
from tb.docs.structure import Port, Structure

__all__ = ["PRESET", "Reference", "markdown"]

# The preset whose widths are shown.
PRESET = "small"
# Folders of hw/, as the pages name them and in their order; others come after them by their own names.
FOLDERS = {
    "": "Engine and cluster", "icu": "Intersection", "ctu": "Cell traversal", "memsys": "Memory system",
    "memsys/patches": "Patches of cells", "memsys/bus": "Bus and caches", "memsys/port": "Port of main memory",
    "memsys/load": "Loads", "memsys/results": "Results",
    "noc": "Network", "control": "Control", "registers": "Registers", "board": "Board",
    "lib": "Library",
}
# Classes whose layouts are on the page on payloads.
PAYLOADS = {formats.__name__ for formats in FORMATS}
ROOT = Path(__file__).parents[2]
# In a diagram: the way from a page to the site's root.
UP = "@UP@"
# Longer lists of fields are cut down to what is outermost.
LONG = 12
# Sections of a docstring that define things.
SECTIONS = ("Parameters", "Members", "Raises", "Returns")


class Reference:
    """Pages of all components.

    Parameters
    ----------
    classes
        Of components.
    structures
        Of those that a machine has been made with.
    """

    def __init__(self, classes: list[type], structures: Mapping[type, Structure]):
        self._structures = structures
        self._by_name: dict[str, list[type]] = {}
        for cls in classes:
            self._by_name.setdefault(cls.__name__, []).append(cls)
        self.classes = sorted(classes, key=lambda cls: cls.__module__)
        there = {self.folder(cls) for cls in classes}
        # Titles by folder.
        self.folders = {folder: title for folder, title in FOLDERS.items() if folder in there} | {
            folder: folder.capitalize() for folder in sorted(there - set(FOLDERS))}
        self._holders: dict[type, dict[str, type]] = {}
        for structure in structures.values():
            for block in structure.blocks:
                self._holders.setdefault(block.cls, {})[structure.cls.__name__] = structure.cls

    def named(self, name: str) -> type:
        """The one class of that name."""
        (cls,) = self._by_name[name]
        return cls

    def structure(self, cls: type) -> Structure | None:
        """What it is made of."""
        return self._structures.get(cls)

    def path(self, cls: type) -> str:
        """Of its page, from the site's root."""
        return f"reference/{cls.__module__.removeprefix('hw.').replace('.', '/')}.md"

    def folder(self, cls: type) -> str:
        """Of its file, below hw/."""
        return cls.__module__.removeprefix("hw.").rpartition(".")[0].replace(".", "/")

    def index_path(self, folder: str) -> str:
        """Of the page on a folder."""
        return f"reference/{folder}/index.md" if folder else "reference/index.md"

    def pages(self) -> dict[str, str]:
        """Markdown of all pages by their paths."""
        return {self.index_path(folder): self._index(folder) for folder in self.folders} | {
            self.path(cls): self._page(cls) for cls in self.classes}

    def link(self, cls: type, here: str) -> str:
        """From the page ``here`` to that of a class."""
        return f"[`{cls.__name__}`]({_up(here)}{self.path(cls)})"

    def diagram(self, cls: type, here: str) -> str:
        """Its blocks, as HTML whose links start at the page ``here``; nothing if there is but one."""
        drawn = self._drawn.get(cls)
        return "" if drawn is None else f'<div class="diagram">\n{drawn.replace(UP, _up(here))}</div>\n'

    @cached_property
    def _drawn(self):
        """Diagrams of all that have several blocks, which are drawn together."""
        def page_of(block):
            return UP + self.path(block).removesuffix("md") + "html" if block.__name__ in self._by_name else None

        shown = [cls for cls, structure in self._structures.items() if len(structure.blocks) > 1 and structure.links]
        return dict(zip(shown, draw([dot(self._structures[cls], page_of=page_of) for cls in shown]), strict=True))

    def timing(self, cls: type, here: str) -> str:
        """What its docstring says of timing, and its latency."""
        said = re.search(r"^Timing\n-+\n(.*?)(?=^\w[\w ]*\n---|^Golden counterpart|\Z)", inspect.getdoc(cls),
                         re.DOTALL | re.MULTILINE)
        text = markdown(said[1].strip(), self._linker(here)) if said else ""
        latency = self._structures[cls].latency
        return text if latency is None else f"{text} With preset `{PRESET}` its latency is {latency} cycles."

    def interface(self, cls: type) -> str:
        """A table of its ports."""
        structure = self._structures[cls]
        rows = [_row(port, count) for port, count in _arrays(structure.ports)]
        return "\n".join(["| port | is | bits | fields |", "|---|---|---|---|", *rows, ""])

    def memories(self, cls: type) -> str:
        """A table of its own memories; nothing if there are none."""
        counts = Counter((store.name, store.depth, store.bits) for store in self._structures[cls].stores)
        return "\n".join(["| memory | rows | bits | how many |", "|---|---|---|---|", *(
            f"| {f'`{name}`' if name else 'of a pipeline'} | {depth:,} | {bits} | {count} |"
            for (name, depth, bits), count in counts.items()), ""]) if counts else ""

    def _index(self, folder):
        here = self.index_path(folder)
        where = f"hw/{folder}/" if folder else "hw/"
        lines = [f"# {self.folders[folder]}", "", f"The components of `{where}`; latencies in cycles with preset "
                 f"`{PRESET}`.", "", "| component | does | latency |", "|---|---|---|"]
        for cls in self.classes:
            if self.folder(cls) == folder:
                structure = self._structures.get(cls)
                latency = "" if structure is None or structure.latency is None else structure.latency
                about = markdown(_about(cls), self._linker(here)).replace("|", r"\|")
                lines.append(f"| {self.link(cls, here)} | {about} | {latency} |")
        return "\n".join(lines) + "\n"

    def _page(self, cls):
        here = self.path(cls)
        source = f"hw/{cls.__module__.removeprefix('hw.').replace('.', '/')}.py"
        bench = source.replace("hw/", "tb/", 1).replace(f"{Path(source).stem}.py", f"test_{Path(source).stem}.py")
        facts = [f"Source: `{source}`."]
        if (ROOT / bench).exists():
            facts.append(f"Bench: `{bench}`.")
        if cls in self._holders:
            holders = ", ".join(self.link(one, here) for _, one in sorted(self._holders[cls].items()))
            facts.append(f"Part of: {holders}.")
        text = [f"# {cls.__name__}", "", " ".join(facts), "", markdown(inspect.getdoc(cls), self._linker(here))]
        structure = self._structures.get(cls)
        if structure is None:
            text += ["", "## Interface", "", f"No part of the engine of preset `{PRESET}`: it is made with what its "
                     "parameters say."]
        else:
            latency = "" if structure.latency is None else f" Latency: {structure.latency} cycles."
            text += ["", "## Interface", "", f"As it is made with preset `{PRESET}`.{latency}", "",
                     self.interface(cls)]
            if diagram := self.diagram(cls, here):
                text += ["## Blocks", "", diagram]
            if memories := self.memories(cls):
                text += ["## Memories", "", memories]
        return "\n".join(text) + "\n"

    def _linker(self, here):
        def link(name):
            classes = self._by_name.get(name, ())
            holder = name.partition(".")[0]
            if holder in PAYLOADS:
                return f"[`{name}`]({_up(here)}payloads.md#{holder.lower()})"
            return self.link(classes[0], here) if len(classes) == 1 else f"`{name}`"

        return link


def markdown(text: str, link=lambda name: f"`{name}`") -> str:
    """A docstring as Markdown.

    Sections become headings, what they define lists of definitions, and names in single backticks what ``link`` makes
    of them.
    """
    lines, result = text.splitlines(), []
    section, in_code = "", False
    for number, line in enumerate(lines):
        below = lines[number + 1] if number + 1 < len(lines) else ""
        if in_code and line and not line.startswith(" "):
            in_code = False
        if in_code:
            result.append(line)
        elif line and re.fullmatch(r"-{3,}", below):
            section = line
            result += [f"## {line}", ""]
        elif re.fullmatch(r"-{3,}", line):
            continue
        elif line.rstrip().endswith("::"):
            in_code = True
            head = line.rstrip().removesuffix("::")
            result.append(_inline(head + ":", link) if head.strip() else "")
        elif section in SECTIONS and line and not line.startswith(" "):
            # A term; whoever defines nothing writes sentences.
            is_term = below.startswith("    ")
            names, colon, shape = line.partition(" : ")
            result += ["", ", ".join(f"`{name}`" for name in names.split(", ")) + colon + _inline(shape, link),
                       ""] if is_term else [_inline(line, link)]
        elif section in SECTIONS and line.startswith("    "):
            first = not lines[number - 1].startswith(" ")
            if first and result[-1] == "":
                result.pop()
            result.append((":   " if first else "    ") + _inline(line[4:], link))
        else:
            result.append(_inline(line, link))
    return re.sub(r"\n{3,}", "\n\n", "\n".join(result)).strip()


def _inline(line, link):
    """Code in two backticks, names in one; all else as it stands."""
    parts = re.split(r"(``.+?``|`[^`]+`)", line)
    for number, part in enumerate(parts):
        if part.startswith("``"):
            parts[number] = part[1:-1]
        elif part.startswith("`"):
            parts[number] = link(part[1:-1])
        else:
            parts[number] = part.replace("<", "&lt;").replace("*", r"\*")
    return "".join(parts)


def _about(cls):
    """The line at the head of its file, without its name."""
    line = inspect.getdoc(inspect.getmodule(cls)).splitlines()[0]
    name, colon, about = line.partition(": ")
    return about if colon else name


def _up(here):
    return "../" * here.count("/")


def _arrays(ports) -> list[tuple[Port, int]]:
    """Ports that differ in their number only are one, with how many there are."""
    found: dict[str, list[Port]] = {}
    for port in ports:
        found.setdefault(re.sub(r"\[\d+\]", "", port.path), []).append(port)
    return [(alike[0], len(alike)) for alike in found.values()]


def _row(port, count):
    name = re.sub(r"\[\d+\]", "", port.path)
    way = "in" if port.is_input else "out"
    what = {"stream": "stream, always ready" if port.always_ready else "stream"}.get(port.kind, port.kind)
    fields = port.fields
    if len(fields) > LONG:
        outer: dict[str, int] = {}
        for field in fields:
            outer[field.name.split(".")[0]] = outer.get(field.name.split(".")[0], 0) + field.bits
        parts = [f"`{outermost}` {bits}" for outermost, bits in outer.items()]
    else:
        parts = [f"`{field.name}` {field.bits}" for field in fields]
    times = f", {count} of them" if count > 1 else ""
    return f"| `{name}` | {way}, {what}{times} | {port.bits} | {', '.join(parts)} |"
