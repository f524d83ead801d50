"""Payloads between the engine's control and its clusters."""

from amaranth.lib.data import StructLayout

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.port.memory_formats import MemoryFormats
from hw.registers.error_code import ErrorCode

__all__ = ["DOORBELL_BITS", "ControlFormats"]

# Of the register that counts the descriptors of the queue.
DOORBELL_BITS = 32


class ControlFormats:
    """All layouts of one configuration.

    Parameters
    ----------
    config
        The configuration.
    """

    def __init__(self, config: Config):
        path, memory, formats = PathFormats(config), MemoryFormats(config), CtuFormats(config)
        #: ``item``, a `MemoryFormats.table_word`, for all clusters or for one of them.
        self.load_word = StructLayout({"item": memory.table_word, "cluster": path.cluster, "is_all": 1})
        number = max(config.memory.address_bits, path.fault["number"].width, DOORBELL_BITS)
        #: An `ErrorCode`, and the address or number concerned; the same with the cluster.
        self.fault = StructLayout({"code": ErrorCode, "number": number})
        self.error = StructLayout({"code": ErrorCode, "cluster": path.cluster, "number": number})
        frustum, traversal = formats.frustum, formats.traversal_frustum
        #: A frustum (`CtuFormats.traversal_frustum`) without its section, and without the cells of the scene.
        self.numbers = StructLayout({
            **{name: field.shape for name, field in frustum if name not in ("section", "tiles_across")},
            **{name: field.shape for name, field in traversal if name not in ("frustum", "cells")}})
