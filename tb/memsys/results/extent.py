"""How far the results of an item reach, and where memory ends."""

from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import HitFormat

__all__ = ["extent_of", "saturated"]


def saturated(number, bits):
    """An address of so many bits, or the number of a beat; one past the end of memory stays there in one bit more."""
    return number if number < 1 << bits else number % (1 << bits) + (1 << bits)


def extent_of(item, config):
    """What a section's command becomes."""
    rays, size = Sector(**item["section"]), HitFormat(item["hit_format"]).bytes
    skipped = item["columns"] - (rays.end_column - rays.first_column)
    hits = item["hits"] + size * (rays.first_row * item["columns"] + rays.first_column)
    return {"hits": saturated(hits, config.memory.address_bits),
            "sums": item["sums"], "sums_address": item["sums_address"], "hit_format": item["hit_format"],
            "last_column": rays.end_column - 1, "single": int(rays.end_column - rays.first_column == 1),
            "jump": (skipped * size + min(size, config.memory.beat_bytes)) // 4}
