"""Payloads of the queue of descriptors, and where the fields of descriptors and completion records are."""

from amaranth.hdl import unsigned
from amaranth.lib.data import StructLayout

from golden.engine.config import Config
from golden.engine.frustum.bundle import Bundle
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR, Kind
from golden.engine.jobs.result_formats import HitFormat, exceeding
from golden.engine.memory_map import REGIONS
from hw.control.control_formats import ControlFormats
from hw.ctu.ctu_formats import CtuFormats
from hw.memsys.patches.path_formats import PathFormats
from hw.registers.error_code import ErrorCode

__all__ = ["COMPLETION_WORDS", "DESCRIPTOR_WORDS", "IN_FLIGHT", "NEAR_INDEX",
           "WORD_BITS", "WORD_BYTES", "Bundle", "JobFormats", "Kind", "byte_of", "elements"]

WORD_BYTES = 8
WORD_BITS = 8 * WORD_BYTES
DESCRIPTOR_WORDS = DESCRIPTOR.dtype.itemsize // WORD_BYTES
COMPLETION_WORDS = COMPLETION.dtype.itemsize // WORD_BYTES
# The index of a word of near cells or of a listed ray: all of them follow the descriptor's words.
NEAR_INDEX = DESCRIPTOR_WORDS
# Sections of a cluster in flight at most: one in its slot, one that is cast, one whose results are written.
IN_FLIGHT = 3


def byte_of(field: str) -> int:
    """The first byte of a field of a descriptor."""
    return DESCRIPTOR.dtype.fields[field][1]


def elements(field: str, *, record: str = "descriptor") -> list[tuple[int, slice]]:
    """Of each element of a field: the word of the record that has it, and its bits there.

    Parameters
    ----------
    field
        Its name.
    record
        ``descriptor`` or ``completion``.
    """
    dtype = {"descriptor": DESCRIPTOR, "completion": COMPLETION}[record].dtype
    shape, first = dtype.fields[field][:2]
    size = shape.base.itemsize
    return [(byte // WORD_BYTES, slice(8 * (byte % WORD_BYTES), 8 * (byte % WORD_BYTES + size)))
            for byte in range(first, first + shape.itemsize, size)]


class JobFormats:
    """All layouts of one configuration.

    Parameters
    ----------
    config
        The configuration.
    """

    def __init__(self, config: Config):
        control, formats = ControlFormats(config), CtuFormats(config)
        #: Numbers of the formats of hits that have the bits of the configuration's numbers.
        self.hit_formats = [one.value for one in HitFormat if not exceeding(config, one, sums=False)]
        #: The largest value of ``sums``, likewise.
        self.sums = int(not exceeding(config, HitFormat.NONE, sums=True))
        address, near = config.memory.address_bits, config.ctu.near_cell_bits
        #: Bits of the number of a cluster.
        self.cluster = PathFormats(config).cluster
        #: A word of a descriptor, or of its near cells and listed rays (``index`` is `NEAR_INDEX`), the ``last`` one or
        #: not. With ``error`` it could not be read.
        self.fetched = StructLayout({"index": range(NEAR_INDEX + 1), "data": WORD_BITS, "last": 1, "error": 1})
        #: The same for a cluster. The last one is ``void`` if the section is refused: what came before it is no
        #: section.
        self.word = StructLayout({"cluster": self.cluster, "index": range(NEAR_INDEX + 1), "data": WORD_BITS,
                                  "last": 1, "void": 1})
        #: The result command of a section: ``hit_format`` and ``sums`` say what is written, ``hits`` and
        #: ``sums_address`` where; ``columns`` of the frustum; ``section``.
        self.results = StructLayout({"hit_format": 2, "sums": 1, "hits": address, "sums_address": address,
                                     "columns": formats.count, "section": formats.section})
        rays = {"rays": unsigned(config.icu.shadow_bits + 1)} if config.icu.shadow_bits else {}
        #: A section in a cluster's slot: ``numbers`` of its frustum, ``section``, ``last_shell``, ``near_cells`` and
        #: the ``bank`` that has them, ``results``; with ``icu.shadow_bits`` also how many ``rays`` are listed.
        self.slot = StructLayout({"numbers": control.numbers, "section": formats.section, "last_shell": formats.shell,
                                  "near_cells": unsigned(near + 1), **rays, "bank": 1, "results": self.results})
        #: Two near cells: the ``bank``, the ``address`` of a word there, the ``cells``, the first one in the low half.
        self.near_pair = StructLayout({"bank": 1, "address": near - 1, "cells": 2 * formats.cell.width})
        #: A section that has been sent to a cluster: ``cluster``, and ``tag`` of its descriptor.
        self.sent = StructLayout({"cluster": self.cluster, "tag": 32})
        load = {"image": WORD_BITS, "regions": len(REGIONS), "copies": 1}
        #: A load: ``image``, ``regions``; with ``copies`` all clusters get the tables of cluster 0. The same with the
        #: ``tag`` of its descriptor.
        self.load, self.load_job = StructLayout(load), StructLayout({"tag": 32, **load})
        #: Shape of a number of sections of a cluster in flight.
        self.in_flight = unsigned(IN_FLIGHT.bit_length())
        #: What has caused a reset: ``code``, the ``number`` concerned, and the oldest section of a ``cluster``, its
        #: ``newest`` one that has begun, or the load (``is_load``).
        self.culprit = StructLayout({"code": ErrorCode, "number": control.fault["number"].shape, "is_load": 1,
                                     "newest": 1, "cluster": self.cluster})
        #: ``code``, and the ``number`` concerned.
        self.refusal = control.fault
        #: A completion record that no cluster writes: ``tag``, ``code``, ``cluster``, ``number``, ``begin``, ``end``.
        self.record = StructLayout({"tag": 32, "code": ErrorCode, "cluster": 8, "number": control.fault["number"].shape,
                                    "begin": 32, "end": 32})
