"""How far the results of an item reach."""

from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import HitFormat

__all__ = ["extent_of"]


def extent_of(item, config):
    """What a section's command becomes."""
    rays, size = Sector(**item["section"]), HitFormat(item["hit_format"]).bytes
    skipped = item["columns"] - (rays.end_column - rays.first_column)
    return {"hits": item["hits"] + size * (rays.first_row * item["columns"] + rays.first_column),
            "sums": item["sums"], "sums_address": item["sums_address"], "hit_format": item["hit_format"],
            "last_column": rays.end_column - 1, "single": int(rays.end_column - rays.first_column == 1),
            "jump": (skipped * size + min(size, config.memory.beat_bytes)) // 4}
