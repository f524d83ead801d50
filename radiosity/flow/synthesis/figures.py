"""Areas and clocks in README.md and docs/, from the history: ``python -m hw figures``."""

import re
import statistics
import textwrap
from dataclasses import replace
from pathlib import Path

from radiosity.flow.output import write_text
from radiosity.flow.synthesis.family import FAMILIES
from radiosity.flow.synthesis.flow import OPTIONS
from radiosity.flow.synthesis.history import MACHINE, ROOT, Record, last_records, machine_parameters, read_history
from radiosity.flow.synthesis.report import UNITS, spread

__all__ = ["MAIN", "pages", "with_tables", "write_tables"]

PRESET = "small"
# What the README shows, if it has been recorded.
MAIN = {
    "icu": ("IntersectionUnit",),
    "ctu": ("TraversalUnit",),
    "memsys": ("MemorySystem", "SystemBusInterface"),
    "control": ("JobControl",),
    "registers": ("Registers",),
    "noc": ("Router-72-2",),
}
# What a machine of preset `board` consists of.
BOARD = {
    "icu": ("IntersectionUnit",),
    "ctu": ("TraversalUnit",),
    "memsys": ("MemorySystem", "PatchStore", "PatchNode", "SystemBusInterface"),
    "noc": ("PatchNetwork",),
}
# A table is between two comments. The first one names its content: the README's units, a block's, some of a block's,
# those of other families, those of preset `board`, or the machine of its bitstream.
_TABLE = re.compile(r"(<!-- area: (\w+)((?: [\w-]+)*) -->\n).*?(<!-- area: end -->)", re.DOTALL)
# The clock of that machine, within a sentence.
_CLOCK = re.compile(r"(<!-- routed -->).*?(<!-- routed: end -->)", re.DOTALL)
# What an ECP5-85 has.
_CAPACITIES = {"lut": 83640, "ff": 83640, "dsp": 156, "bram": 208}


def pages() -> list[Path]:
    """README.md and the pages of docs/ that have such tables or clocks."""
    return [path for path in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
            if _TABLE.search(text := path.read_text()) or _CLOCK.search(text)]


def with_tables(text: str, history: list[Record]) -> str:
    """A page with its tables and clocks filled in."""
    last = last_records(history)
    machine = last.get(("ecp5", "board", machine_parameters("board", ()), *MACHINE))

    def of(units, family="ecp5", preset=PRESET):
        keys = [(family, preset, "", block, unit) for block, names in units.items() for unit in names]
        return [last[key] for key in keys if key in last]

    def elsewhere():
        """Of units that were measured in another family too, in all of them."""
        units = [(block, unit) for block, names in UNITS.items() for unit in names
                 if any(of({block: [unit]}, family) for family in FAMILIES if family != "ecp5")]
        return [record for block, unit in units for family in FAMILIES for record in of({block: [unit]}, family)]

    def table(marked):
        start, what, names, end = marked.groups()
        if what == "families":
            records, lines_of = elsewhere(), _areas
        elif what == "board":
            records, lines_of = of(BOARD, preset="board"), _parts
        elif what == "machine":
            records, lines_of = [one for one in [machine] if one], _machines
        else:
            records, lines_of = of(MAIN if what == "main" else {what: names.split() or UNITS[what]}), _clocks
        lines = lines_of(records) if records else ["Nothing has been recorded yet."]
        return "\n".join([start, *lines, "", end])

    return _CLOCK.sub(lambda marked: "".join([marked[1], _clock(machine), marked[2]]), _TABLE.sub(table, text))


def write_tables() -> list[Path]:
    """Write all tables; returns the pages that have changed."""
    history, changed = read_history(), []
    for path in pages():
        text = path.read_text()
        if (new := with_tables(text, history)) != text:
            write_text(path, new)
            changed.append(path)
    return changed


def _clocks(records):
    lines = ["| unit | latency | LUT | FF | DSP | block RAM | MHz | seeds | commit |", "|---" * 9 + "|"]
    for record in records:
        cells = [f"`{record.unit}`", "" if record.latency is None else record.latency, *_area(record),
                 spread(record.mhz) if record.mhz else "", ", ".join(map(str, record.seeds)), record.commit]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    others = {}
    for record in records:
        routing = " --routability-driven" if record.routing == "routability-driven" else ""
        if record.seeds and (routing or record.options != " ".join(OPTIONS)):
            others.setdefault(f'--nextpnr "{record.options}"{routing}', []).append(f"`{record.unit}`")
    others = [f'{", ".join(units)} with `{options}`' for options, units in others.items()]
    about = [f"{FAMILIES['ecp5'].title}, preset `{PRESET}`, each unit alone between registers.",
             FAMILIES["ecp5"].counted, "MHz: Fmax after routing; of several seeds the least, the median and the best.",
             *([] if all(record.mhz for record in records) else ["Without MHz: synthesised, not routed."]),
             f"{_tools(records)}.",
             *([f"Other options of nextpnr: {'; '.join(others)}."] if others else [])]
    return [*lines, "", _filled(" ".join(about))]


def _areas(records):
    lines = ["| unit | family | LUT | FF | DSP | block RAM | commit |", "|---" * 7 + "|"]
    for record in records:
        cells = [f"`{record.unit}`", FAMILIES[record.family].title, *_area(record), record.commit]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    counted = [_filled(f"* {family.title}: {family.counted}", indent="  ") for name, family in FAMILIES.items()
               if any(record.family == name for record in records)]
    # Nothing was placed for this table.
    tools = _tools(replace(record, tools=record.tools.partition(", nextpnr")[0]) for record in records)
    return [*lines, "", f"Preset `{PRESET}`. {tools}. What is counted:", "", *counted]


def _parts(records):
    lines = ["| unit | LUT | FF | DSP | block RAM | commit |", "|---" * 6 + "|"]
    lines += [f"| `{record.unit}` | {' | '.join(map(str, _area(record)))} | {record.commit} |" for record in records]
    family = FAMILIES["ecp5"]
    return [*lines, "", _filled(f"{family.title}, preset `board`, each unit alone, synthesised and not routed. "
                                f"{family.counted} {_tools(records)}.")]


def _machines(records):
    lines = ["| machine | LUT | registers | DSP blocks | block RAM | MHz | seeds | commit |", "|---" * 8 + "|"]
    for record in records:
        cells = [f"{getattr(record, name):,} ({100 * getattr(record, name) / most:.0f} %)"
                 for name, most in _CAPACITIES.items()]
        cells += [spread(record.mhz, digits=1), ", ".join(map(str, record.seeds)), record.commit]
        lines.append(f"| `{record.unit}` | {' | '.join(cells)} |")
    options = ", ".join(f'`--nextpnr "{record.options}"`' for record in records)
    return [*lines, "", _filled(
        f"{FAMILIES['ecp5'].title}, preset `board` with its memory and its host, placed and routed with "
        f"{options}. MHz: of several seeds the least, the median and the best. {_tools(records)}.")]


def _clock(record):
    if record is None:
        return "an unknown clock"
    return f"{statistics.median(record.mhz):.1f} MHz ({record.routes})"


def _tools(records):
    """Each version of each tool once."""
    return ", ".join(dict.fromkeys(tool for record in records for tool in record.tools.split(", ")))


def _area(record):
    return record.lut, record.ff, record.dsp, record.bram


def _filled(text, indent=""):
    return textwrap.fill(text, 128, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
