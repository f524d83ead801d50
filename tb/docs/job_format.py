"""The tables of docs/job-format.md, from the layouts that host and machine are made from."""

from golden.jobs.completion import COMPLETION
from golden.jobs.descriptor import DESCRIPTOR, RULES, Kind
from golden.memory_map.layout import REGIONS
from tb.docs.memory_layout import record_table

__all__ = ["job_tables"]


def job_tables() -> str:
    """The formats as Markdown: descriptor, its rules, completion record, and the image of a phase."""
    rules = ["### rules of a descriptor", "", "| field | rule | of | error |", "|---|---|---|---|"]
    for rule in RULES:
        of = "all" if len(rule.kinds) == len(Kind) else "sections"
        rules.append(f"| `{rule.field}` | {rule.about} | {of} | `{rule.code}` |")
    regions = ["### regions of the image of a phase", "", "| bit | region | life | one record per |",
               "|---|---|---|---|"]
    regions += [f"| {bit} | `{region.name}` | {region.life} | {region.record} |"
                for bit, region in enumerate(REGIONS)]
    own = [record_table(region, has_life=True) for region in REGIONS if region.name in ("patches", "clusters")]
    return "\n".join([record_table(DESCRIPTOR), "\n".join(rules) + "\n", record_table(COMPLETION),
                      "\n".join(regions) + "\n", *own])
