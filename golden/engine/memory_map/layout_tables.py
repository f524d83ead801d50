"""The layout of a memory image as tables of a page, from the layout that host and machine are made from."""

from golden.engine.memory_map.layout import ENTRY, HEADER, REGIONS, Region
from golden.engine.memory_map.rules import RULES

__all__ = ["layout_tables", "record_table"]


def layout_tables() -> str:
    """The layout as Markdown: the header, the region table, one table for each region, and the rules."""
    return "\n".join([*(record_table(region, has_life=region not in (HEADER, ENTRY))
                        for region in (HEADER, ENTRY, *REGIONS)), _rules()])


def record_table(region: Region, *, has_life: bool = False) -> str:
    """The fields of one record as Markdown, under a heading of their own.

    Parameters
    ----------
    region
        The layout.
    has_life
        States its life.
    """
    life = f" Life: {region.life}." if has_life else ""
    lines = [f"### {region.name}", "",
             f"{region.about}{life} One record of {region.dtype.itemsize} bytes per {region.record}.", "",
             "| byte | field | type | meaning |", "|---|---|---|---|"]
    for field in region.fields:
        count = f" x {field.count}" if field.count > 1 else ""
        lines.append(f"| {region.dtype.fields[field.name][1]} | `{field.name}` | {field.type}{count} | {field.about} |")
    return "\n".join(lines) + "\n"


def _rules():
    """What the fields must be, under a heading of their own."""
    lines = ["## Rules", "", "A load that reads a record without one of these ends with the code, and with the "
             "region's first byte as its address. A patch that no node holds is read by casts: their sections end "
             "with `PATH_BUS`.", "", "| region | fields | must be | code |", "|---|---|---|---|"]
    for rule in RULES:
        fields = ", ".join(f"`{name}`" for name in rule.fields)
        lines.append(f"| `{rule.region}` | {fields} | {rule.about} | `{rule.kind.code}` |")
    return "\n".join(lines) + "\n"
