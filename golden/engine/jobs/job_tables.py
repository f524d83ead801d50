"""The formats of jobs as tables of a page, from the layouts that host and machine are made from."""

from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR, RULES, Kind
from golden.engine.memory_map.layout import REGIONS
from golden.engine.memory_map.layout_tables import record_table

__all__ = ["job_tables"]


def job_tables() -> str:
    """The formats as Markdown: descriptor, its rules, completion record, and the bits of a load."""
    rules = ["### rules of a descriptor", "", "| field | rule | of | error |", "|---|---|---|---|"]
    for rule in RULES:
        of = "all" if len(rule.kinds) == len(Kind) else {Kind.FRUSTUM: "sections", Kind.LOAD: "loads"}[rule.kinds[0]]
        rules.append(f"| `{rule.field}` | {rule.about} | {of} | `{rule.code}` |")
    regions = ["### regions of a load", "", "| bit | region | life | one record per |",
               "|---|---|---|---|"]
    regions += [f"| {bit} | `{region.name}` | {region.life} | {region.record} |"
                for bit, region in enumerate(REGIONS)]
    return "\n".join([record_table(DESCRIPTOR), "\n".join(rules) + "\n", record_table(COMPLETION),
                      "\n".join(regions) + "\n"])
