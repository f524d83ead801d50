"""Contents of the site that are made from the code."""

import re
from collections.abc import Callable

from golden.engine.config import PRESETS, Config
from hw.async_engine import AsyncEngine
from hw.board.board_shell import BoardShell
from hw.board.program import Operation, Program, Step
from hw.cluster import Cluster
from hw.engine import Engine
from hw.lib.black_box import BlackBox
from radiosity.flow.synthesis.figures import with_tables
from radiosity.flow.synthesis.history import read_history
from radiosity.flow.synthesis.report import UNITS, make_unit
from radiosity.tasks.config import about_parameters
from tb.docs.payloads import payloads
from tb.docs.reference import PRESET, Reference
from tb.docs.structure import component_classes, structures
from tb.docs.verification import report
from tb.docs.waveforms import WAVEFORMS

__all__ = ["UNIT_PAGES", "Contents", "makers"]

# Components whose diagrams and ports are shown on pages of docs/.
UNIT_PAGES = {
    "engine.md": ("Engine", "Cluster"),
    "intersection-unit.md": ("IntersectionUnit", "PatchSetup", "IntersectionPipeline"),
    "traversal-unit.md": ("TraversalUnit", "RayTraversal", "Survival"),
    "memory-path.md": ("MemorySystem", "SystemBusInterface"),
    "caches.md": ("Cache",),
    "main-memory.md": ("MainMemoryPort", "PreloadDma", "ResultWriter"),
    "network.md": ("NetworkInterface", "Router"),
    "board.md": ("BoardShell",),
}


def makers(config: Config) -> list[Callable]:
    """Of the engine, of what is measured alone, and of a board's shell."""
    units = [lambda block=block, unit=unit: make_unit(block, unit, config)
             for block, names in UNITS.items() if block != "engine" for unit in names]
    program = Program(steps=(Step(operation=Operation.HALT),) * 2, error=1, memory=bytes(64))
    return [lambda: Engine(config=config, black_boxes=True),
            lambda: AsyncEngine(config=config, black_boxes=True), lambda: Cluster(config=config), *units,
            lambda: BoardShell(config=config, program=program, divisor=16, black_boxes=True)]


class Contents:
    """All of it."""

    def __init__(self):
        classes = [cls for cls in component_classes().values() if cls is not BlackBox]
        found = structures(makers(PRESETS[PRESET]), stands_for={BlackBox: Cluster})
        self._reference = Reference(classes, found)

    def navigation(self) -> list:
        """The reference's part of it, as in mkdocs.yml."""
        reference = self._reference
        return [{title: [reference.index_path(folder), *(
            reference.path(cls) for cls in reference.classes if reference.folder(cls) == folder)]}
            for folder, title in reference.folders.items()]

    def pages(self) -> dict[str, str]:
        """Texts of pages and of waveforms by their paths."""
        return self._reference.pages() | {"verification-report.md": report(), "parameters.md": _parameters(),
                                            "units.md": _units(), "payloads.md": payloads(PRESETS[PRESET], PRESET)} | {
            _waveform_path(page): waveform.draw() for page, waveform in WAVEFORMS.items()}

    def complete(self, text: str, here: str) -> str:
        """A page with the parts whose positions it names, and what is shown of its units below.

        Positions are comments: ``<!-- diagram Cluster -->``.
        """
        reference = self._reference

        def part(match):
            kind, name = match[1], match[2]
            return {"diagram": lambda: reference.diagram(reference.named(name), here)}[kind]()

        text = re.sub(r"<!-- (\w+) (\w+) -->", part, text)
        for name in UNIT_PAGES.get(here, ()):
            cls = reference.named(name)
            text += "\n".join([
                "", f"## {name}, from the code", "",
                f"With preset `{PRESET}`. What the ports mean: {reference.link(cls, here)}.", "",
                reference.diagram(cls, here), "", reference.interface(cls), "",
                f"**Timing.** {reference.timing(cls, here)}", ""])
        if here in WAVEFORMS:
            about = WAVEFORMS[here].about
            about = re.sub(r"`(\w+)`", lambda match: reference.link(reference.named(match[1]), here), about)
            text += "\n".join(["", "## Waveform", "", f"From a simulation with preset `tiny`: {about}.", "",
                               f"![Waveform]({_waveform_path(here)})", "{: .diagram }", ""])
        return text


def _parameters():
    """The page on what a configuration says."""
    values, about = {name: preset.parameters() for name, preset in PRESETS.items()}, about_parameters(Config())
    lines = ["# Parameters", "", "What a configuration says, and what the presets say. On all command lines "
             "`-P PATH=VALUE` changes one. Whatever cannot be is refused with the reason. Widths that follow: "
             "`python -m golden config small`.", ""]
    for group in dict.fromkeys(path.partition(".")[0] for path in about):
        lines += [f"## {group}", "", f"| parameter | {' | '.join(values)} | what it is |",
                  "|---" * (len(values) + 2) + "|"]
        lines += [f"| `{path}` | {' | '.join(str(preset[path]) for preset in values.values())} | {text} |"
                  for path, text in about.items() if path.startswith(f"{group}.")]
        lines.append("")
    return "\n".join(lines)


def _units():
    """The page on what each unit takes of an FPGA."""
    lines = ["# Area of each unit", "", "The last recorded measurement of every unit: what it takes of an FPGA, and "
             "the clock that it reaches alone. The page on area has the method.", ""]
    for block in UNITS:
        lines += [f"## {block}", "", f"<!-- area: {block} -->", "<!-- area: end -->", ""]
    lines += ["## Other families", "", "<!-- area: families -->", "<!-- area: end -->", ""]
    return with_tables("\n".join(lines), read_history())


def _waveform_path(page):
    return f"waveforms/{page.removesuffix('.md')}.svg"
