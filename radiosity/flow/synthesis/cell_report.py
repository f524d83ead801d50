"""Tables of area and delay in standard cells, unit by unit."""

from dataclasses import dataclass
from pathlib import Path

from golden.engine.config import PRESETS, Config
from radiosity.flow.synthesis.report import changed_parameters, make_unit
from radiosity.flow.synthesis.standard_cells import COUNTED, CellArea, map_to_cells

__all__ = ["CellRow", "cell_table", "measure_cells"]


@dataclass(frozen=True, kw_only=True)
class CellRow:
    """One unit in standard cells."""

    unit: str
    latency: int | None
    area: CellArea


def measure_cells(block: str, unit: str, config: Config, liberty: Path, folder: Path) -> CellRow:
    """Map one of `radiosity.flow.synthesis.report.UNITS` to the cells of a Liberty file.

    Raises
    ------
    InputError
        As of `map_to_cells`.
    """
    component = make_unit(block, unit, config)
    return CellRow(unit=unit, latency=getattr(component, "latency", None),
                   area=map_to_cells(component, liberty, folder / unit))


def cell_table(rows: list[CellRow], *, block: str, preset: str, config: Config, liberty: Path, tools: str) -> str:
    """The figures as Markdown, with all that is needed to get them again."""
    lines = ["| unit | latency | area | area of registers | registers | RAM bits | delay (ns) |", "|---" * 7 + "|"]
    for row in rows:
        area = row.area
        lines.append(f"| {row.unit} | {'' if row.latency is None else row.latency} | {area.area:.0f} | "
                     f"{area.register_area:.0f} | {area.registers} | {area.ram_bits} | {area.delay:.2f} |")
    return "\n".join([f"# {block}: {liberty.name}", "", *lines, "", COUNTED, "",
                      f"{tools}; preset {preset}{changed_parameters(config, PRESETS[preset])}.", ""])
