"""Payloads of the streams from cells to vertices."""

from amaranth.lib import enum
from amaranth.lib.data import StructLayout

from golden.engine.config import Config
from hw.formats import Formats
from hw.memsys.patches.path_fault import PathFault

__all__ = ["BEATS", "PathFormats", "RequestKind"]

# Beats of a patch on the bus and in a cache: id and surface, then a vertex each.
BEATS = 5
# Bits of a number in a memory image.
WORD = 32


class RequestKind(enum.Enum, shape=1):
    """The kinds of requests on the bus."""

    CELL = 0
    PATCH = 1


class PathFormats:
    """All layouts of one configuration.

    A *listed* number is a patch id with a bit above it: the list names a patch that does not exist.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    cell_bits, part_bits
        Bits of the number of a cell of the scene, and of a part of its list.
    listed_bits
        Bits of a listed number.
    entry_bits, own_patch_bits
        Bits of an address in the patch table, and in the resident set.
    cluster
        Bits of the number of a cluster.
    beat_bits
        Bits of a beat of a patch.
    """

    def __init__(self, config: Config):
        memsys = self._memsys = config.memsys
        self._address_bits = config.memory.address_bits
        self._slot = range(memsys.cache_fetches)
        self._formats = formats = Formats(config)
        self.cell_bits = memsys.scene_cells.bit_length() - 1
        self.listed_bits = formats.patch.width + 1
        # Enough for a list of all patches. Of a longer one the last part that can be named is an error.
        self.part_bits = max(1, self.listed_bits - (memsys.reply_ids.bit_length() - 1))
        self.entry_bits = memsys.own_entries.bit_length() - 1
        self.own_patch_bits = memsys.own_patches.bit_length() - 1
        self._node_bits = config.noc.node_bits
        self.cluster = max(1, config.noc.node_bits)
        self.vertex_bits = 3 * formats.scene.width
        self.beat_bits = max(self.vertex_bits, formats.patch.width + formats.surface.width)

    @property
    def scene(self) -> StructLayout:
        """How many cells, entries of patch lists and patches there are."""
        return StructLayout({"cells": range(self._memsys.scene_cells + 1), "lists": WORD, "patches": self.listed_bits})

    @property
    def cell_load(self) -> StructLayout:
        """A record of the cell address table, and its address."""
        return StructLayout({"address": WORD, "record": StructLayout({"pointer": WORD, "count": WORD})})

    @property
    def list_load(self) -> StructLayout:
        """An entry of the patch address table."""
        return StructLayout({"address": WORD, "record": WORD})

    @property
    def type_load(self) -> StructLayout:
        """Where a patch is held; the address of the record is its id."""
        return StructLayout({"address": WORD, "record": StructLayout({"cluster": WORD, "address": WORD})})

    @property
    def geometry_load(self) -> StructLayout:
        """A word of a patch's record in a memory image; the address is the local one."""
        return StructLayout({"address": WORD, "word": 3, "record": 64})

    @property
    def list_extent(self) -> StructLayout:
        """A list of the patch address table, of at least one entry."""
        return StructLayout({"pointer": self.entry_bits, "count": self.entry_bits + 1})

    @property
    def found_cell(self) -> StructLayout:
        """A cell, and its list if that is in the table; otherwise the bus is requested, or the list is wrong."""
        return StructLayout({"cell": self.cell_bits, "list": self.list_extent, "is_own": 1, "is_empty": 1, "wrong": 1})

    @property
    def listed(self) -> StructLayout:
        """An entry of a list, the ``last`` one or not."""
        return StructLayout({"number": self.listed_bits, "last": 1})

    @property
    def found_patch(self) -> StructLayout:
        """A patch, and the cluster and the local address that hold it, if any."""
        return StructLayout({"patch": self._formats.patch, "is_held": 1, "cluster": self.cluster,
                             "address": self.own_patch_bits, "wrong": 1})

    @property
    def cell_key(self) -> StructLayout:
        """A part of a cell's list."""
        return StructLayout({"cell": self.cell_bits, "part": self.part_bits})

    @property
    def cell_beat(self) -> StructLayout:
        """An entry of a part: a listed number if ``is_id``. ``more``: there is another part."""
        return StructLayout({"number": self.listed_bits, "is_id": 1, "more": 1})

    @property
    def cell_fetch(self) -> StructLayout:
        """A part of a cell's list that a slot of the cell cache waits for."""
        return StructLayout({"slot": self._slot, "key": self.cell_key})

    @property
    def cell_fill(self) -> StructLayout:
        """An entry of that part."""
        return StructLayout({"slot": self._slot, "beat": range(self._memsys.reply_ids), "data": self.cell_beat,
                             "error": 1})

    @property
    def patch_fetch(self) -> StructLayout:
        """A patch that a slot of the patch cache waits for."""
        return StructLayout({"slot": self._slot, "key": self._formats.patch})

    @property
    def patch_fill(self) -> StructLayout:
        """A beat of that patch."""
        return StructLayout({"slot": self._slot, "beat": range(BEATS), "data": self.beat_bits, "error": 1})

    @property
    def patch_head(self) -> StructLayout:
        """The first beat of a patch."""
        return StructLayout({"patch": self._formats.patch, "surface": self._formats.surface})

    @property
    def request(self) -> StructLayout:
        """``key`` is a `cell_key` or a patch id."""
        return StructLayout({"kind": RequestKind,
                             "key": max(self.cell_bits + self.part_bits, self._formats.patch.width)})

    @property
    def remote_request(self) -> StructLayout:
        """A patch that another cluster, at ``node``, holds; of a request from there, the node that requests it."""
        return StructLayout({"node": self._node_bits, "patch": self._formats.patch})

    @property
    def store_request(self) -> StructLayout:
        """A patch of the patch store: from another cluster, at ``node``, if ``is_remote``; otherwise from the bus."""
        return StructLayout({"patch": self._formats.patch, "node": self._node_bits, "is_remote": 1})

    @property
    def remote_found(self) -> StructLayout:
        """A remote request after its lookup."""
        return StructLayout({"node": self._node_bits, "found": self.found_patch})

    @property
    def remote_reply(self) -> StructLayout:
        """A vertex of a patch for the cluster at ``node``."""
        return StructLayout({"node": self._node_bits, "vertex": self._formats.patch_vertex})

    @property
    def bus_request(self) -> StructLayout:
        """A request of a cluster."""
        return StructLayout({"source": self.cluster, "item": self.request})

    @property
    def bus_reply(self) -> StructLayout:
        """A beat of a reply. ``hit``: it was in a cache. ``data`` is a `cell_beat`, a `patch_head` or a vertex.

        ``error``, the same in all beats of a reply: that to a cell is one beat without an id, that to a patch has all
        beats, of which the head names the patch and the vertices are undefined.
        """
        return StructLayout({"cluster": self.cluster, "kind": RequestKind, "last": 1, "error": 1, "hit": 1,
                             "data": max(self.beat_bits, self.listed_bits + 2)})

    @property
    def bases(self) -> StructLayout:
        """Addresses of the cells' records, the entries of all lists and the patches' records: multiples of 64."""
        return StructLayout(dict.fromkeys(("cells", "lists", "patches"), self._address_bits))

    @property
    def fault(self) -> StructLayout:
        """A fault, and the number of the cell or patch concerned."""
        return StructLayout({"code": PathFault, "number": 24})
