"""The layout of a memory image as tables of a page, from the layout that host and machine are made from."""

from golden.memory_map.layout import ENTRY, HEADER, REGIONS, Region

__all__ = ["layout_tables", "record_table"]


def layout_tables() -> str:
    """The layout as Markdown: the header, the region table, and one table for each region."""
    return "\n".join(record_table(region, has_life=region not in (HEADER, ENTRY))
                     for region in (HEADER, ENTRY, *REGIONS))


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
