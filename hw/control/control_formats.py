"""Payloads between the engine's control and its clusters."""

from amaranth.lib.data import StructLayout

from golden.config import Config
from hw.ctu.ctu_formats import CtuFormats
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.path_formats import PathFormats
from hw.registers.error_code import ErrorCode

__all__ = ["ControlFormats"]


class ControlFormats:
    """All layouts of one configuration.

    Members
    -------
    load_word
        A word of a memory image as `hw.memsys.preload_dma.PreloadDma` gives it, for all clusters or for one of them.
    fault, error
        An `ErrorCode`, and what it is about; the same with the cluster.
    results
        Where the results of a frustum belong, and how many columns it has.
    numbers
        What a frustum is, but for the section (`Formats.frustum`, ``traversal_frustum``).
    """

    def __init__(self, config: Config):
        path, memory, formats = PathFormats(config), MemoryFormats(config), CtuFormats(config)
        self.load_word = StructLayout({"item": memory.table_word, "cluster": path.cluster, "is_all": 1})
        number = max(config.memory.address_bits, 24)
        self.fault = StructLayout({"code": ErrorCode, "number": number})
        self.error = StructLayout({"code": ErrorCode, "cluster": path.cluster, "number": number})
        self.results = StructLayout({"hits": memory.table, "sums": memory.table, "columns": formats.count})
        frustum, traversal = formats.frustum, formats.traversal_frustum
        self.numbers = StructLayout({
            **{name: field.shape for name, field in frustum if name not in ("section", "tiles_across")},
            **{name: field.shape for name, field in traversal if name != "frustum"}})
