"""Payloads of the results of a frustum."""

from amaranth.lib import enum
from amaranth.lib.data import StructLayout

from golden.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.memsys.image_layout import COUNT_BITS

__all__ = ["ResultFormats", "ResultKind"]


class ResultKind(enum.Enum, shape=1):
    """The hits of a section, or the sums of all patches."""

    HITS = 0
    SUMS = 1


class ResultFormats:
    """All layouts of one configuration.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    hit : StructLayout
        ``column`` and ``row`` of a ray of the frustum, its ``hit`` (`IcuFormats.hit`), ``last`` of its section or not.
    sum : StructLayout
        `IcuFormats.patch_sum`.
    command : StructLayout
        Of the write DMA: ``kind``; ``address`` and ``count`` of the region; ``columns`` of the frustum and ``section``
        (hits); ``total`` (sums).
    """

    def __init__(self, config: Config):
        formats = IcuFormats(config)
        self.hit = StructLayout({"column": formats.index, "row": formats.index, "hit": formats.hit, "last": 1})
        self.sum = formats.patch_sum
        self.command = StructLayout({
            "kind": ResultKind, "address": config.memory.address_bits, "count": COUNT_BITS, "columns": formats.count,
            "section": formats.section, "total": formats.weight_sum})
