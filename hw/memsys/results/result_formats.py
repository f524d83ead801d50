"""Payloads of the results of a section."""

from amaranth.lib import enum
from amaranth.lib.data import StructLayout

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["LANE_BITS", "HitFormat", "ResultFormats", "lanes_of"]

# A beat is made of lanes, as wide as the smallest item that is written.
LANE_BITS = 32


class HitFormat(enum.Enum, shape=2):
    """What is written of a ray: nothing, or 16, 8 or 4 bytes; see `golden.engine.jobs.result_formats`."""

    NONE = 0
    FULL = 1
    COMPACT = 2
    IDS = 3


def lanes_of(config: Config) -> int:
    """Lanes of a beat."""
    return config.memory.data_bits // LANE_BITS


class ResultFormats:
    """All layouts of one configuration.

    Parameters
    ----------
    config
        The configuration.
    """

    def __init__(self, config: Config):
        formats, memory = IcuFormats(config), MemoryFormats(config)
        address = config.memory.address_bits
        #: `IcuFormats.read_ray`. Words of a list are hits of 8 bytes.
        self.hit = formats.read_ray
        #: `IcuFormats.section_sum`.
        self.section_sum = formats.section_sum
        #: Of the result writer: ``hit_format`` (`HitFormat`); whether ``sums`` are written; the addresses ``hits``, of
        #: the hit of ray (0, 0) of the frustum and a multiple of a hit's bytes, and ``sums_address``, a multiple of 8;
        #: ``columns`` of the frustum; and the ``section``.
        self.section_command = StructLayout({
            "hit_format": HitFormat, "sums": 1, "hits": address, "sums_address": address, "columns": formats.count,
            "section": formats.section})
        #: The same with the address ``hits`` of the section's first ray, its ``last_column``, whether a row is a
        #: ``single`` hit, and ``jump``: lanes from the last part of a row's last hit to the next row.
        self.section_extent = StructLayout({
            "hit_format": HitFormat, "sums": 1, "hits": address + 1, "sums_address": address,
            "last_column": formats.index, "single": 1, "jump": config.icu.side_bits + 4})
        #: The fault's ``code`` and ``address``; the number of words of ``sums``.
        self.section_done = StructLayout({
            "code": Fault, "address": address, "sums": config.icu.patch_bits + 1})
        #: A beat's ``number``, its ``data`` and those ``lanes`` of it that are written; its request ``ends`` with it or
        #: not.
        self.beat = StructLayout({
            "number": memory.beat_bits + 1, "data": config.memory.data_bits, "lanes": lanes_of(config), "ends": 1})
