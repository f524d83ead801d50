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
        memsys, formats, node = config.memsys, Formats(config), config.noc.node_bits
        slot = range(memsys.cache_fetches)
        self.cell_bits = memsys.scene_cells.bit_length() - 1
        self.listed_bits = formats.patch.width + 1
        # Enough for a list of all patches. Of a longer one the last part that can be named is an error.
        self.part_bits = max(1, self.listed_bits - (memsys.reply_ids.bit_length() - 1))
        self.entry_bits = memsys.own_entries.bit_length() - 1
        self.own_patch_bits = memsys.own_patches.bit_length() - 1
        self.cluster = max(1, node)
        self.vertex_bits = 3 * formats.scene.width
        self.beat_bits = max(self.vertex_bits, formats.patch.width + formats.surface.width)
        #: How many cells, entries of patch lists and patches there are.
        self.scene = StructLayout({"cells": range(memsys.scene_cells + 1), "lists": WORD, "patches": self.listed_bits})
        #: A record of the cell address table, and its address.
        self.cell_load = StructLayout({"address": WORD, "record": StructLayout({"pointer": WORD, "count": WORD})})
        #: An entry of the patch address table.
        self.list_load = StructLayout({"address": WORD, "record": WORD})
        #: Where a patch is held; the address of the record is its id.
        self.type_load = StructLayout({"address": WORD, "record": StructLayout({"cluster": WORD, "address": WORD})})
        #: A word of a patch's record in a memory image; the address is the local one.
        self.geometry_load = StructLayout({"address": WORD, "word": 3, "record": 64})
        #: A list of the patch address table, of at least one entry.
        self.list_extent = StructLayout({"pointer": self.entry_bits, "count": self.entry_bits + 1})
        #: A cell, and its list if that is in the table; otherwise the bus is requested, or the list is wrong.
        self.found_cell = StructLayout({"cell": self.cell_bits, "list": self.list_extent, "is_own": 1, "is_empty": 1,
                                        "wrong": 1})
        #: An entry of a list, the ``last`` one or not.
        self.listed = StructLayout({"number": self.listed_bits, "last": 1})
        #: A patch, and the cluster and the local address that hold it, if any.
        self.found_patch = StructLayout({"patch": formats.patch, "is_held": 1, "cluster": self.cluster,
                                         "address": self.own_patch_bits, "wrong": 1})
        #: A part of a cell's list.
        self.cell_key = StructLayout({"cell": self.cell_bits, "part": self.part_bits})
        #: An entry of a part: a listed number if ``is_id``. ``more``: there is another part.
        self.cell_beat = StructLayout({"number": self.listed_bits, "is_id": 1, "more": 1})
        #: A part of a cell's list that a slot of the cell cache waits for.
        self.cell_fetch = StructLayout({"slot": slot, "key": self.cell_key})
        #: An entry of that part.
        self.cell_fill = StructLayout({"slot": slot, "beat": range(memsys.reply_ids), "data": self.cell_beat,
                                       "error": 1})
        #: A patch that a slot of the patch cache waits for.
        self.patch_fetch = StructLayout({"slot": slot, "key": formats.patch})
        #: A beat of that patch.
        self.patch_fill = StructLayout({"slot": slot, "beat": range(BEATS), "data": self.beat_bits, "error": 1})
        #: The first beat of a patch.
        self.patch_head = StructLayout({"patch": formats.patch, "surface": formats.surface})
        #: ``key`` is a `cell_key` or a patch id.
        self.request = StructLayout({"kind": RequestKind,
                                     "key": max(self.cell_bits + self.part_bits, formats.patch.width)})
        #: A patch that another cluster, at ``node``, holds; of a request from there, the node that requests it.
        self.remote_request = StructLayout({"node": node, "patch": formats.patch})
        #: A patch of the patch store: from another cluster, at ``node``, if ``is_remote``; otherwise from the bus.
        self.store_request = StructLayout({"patch": formats.patch, "node": node, "is_remote": 1})
        #: A remote request after its lookup.
        self.remote_found = StructLayout({"node": node, "found": self.found_patch})
        #: A vertex of a patch for the cluster at ``node``.
        self.remote_reply = StructLayout({"node": node, "vertex": formats.patch_vertex})
        #: A request of a cluster.
        self.bus_request = StructLayout({"source": self.cluster, "item": self.request})
        #: A beat of a reply. ``hit``: it was in a cache. ``data`` is a `cell_beat`, a `patch_head` or a vertex.
        #: ``error``, the same in all beats of a reply: that to a cell is one beat without an id, that to a patch has
        #: all beats, of which the head names the patch and the vertices are undefined.
        self.bus_reply = StructLayout({"cluster": self.cluster, "kind": RequestKind, "last": 1, "error": 1, "hit": 1,
                                       "data": max(self.beat_bits, self.listed_bits + 2)})
        #: Addresses of the cells' records, the entries of all lists and the patches' records: multiples of 64.
        self.bases = StructLayout(dict.fromkeys(("cells", "lists", "patches"), config.memory.address_bits))
        #: A fault, and the number of the cell or patch concerned.
        self.fault = StructLayout({"code": PathFault, "number": 24})
