"""The tables of docs/memory-map.md, from the layout that host and machine are made from."""

from golden.memory_map import ENTRY, HEADER, REGIONS

__all__ = ["layout_tables"]


def layout_tables() -> str:
    """The layout as Markdown: the header, the region table, and one table for each region."""
    lines = []
    for region in (HEADER, ENTRY, *REGIONS):
        size = region.dtype.itemsize
        kept = "" if region in (HEADER, ENTRY) else f" Life: {region.life}."
        lines += [f"### {region.name}", "", f"{region.about}{kept} One record of {size} bytes per {region.record}.", "",
                  "| byte | field | type | meaning |", "|---|---|---|---|"]
        for field in region.fields:
            count = f" x {field.count}" if field.count > 1 else ""
            lines.append(f"| {region.dtype.fields[field.name][1]} | `{field.name}` | {field.type}{count} | "
                         f"{field.about} |")
        lines.append("")
    return "\n".join(lines)
