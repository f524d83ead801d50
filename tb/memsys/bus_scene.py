"""A drawn scene in memory, requests of clusters for its cells and patches, and what must come of them."""

import random

import numpy as np

from golden.engine.config import Config
from golden.engine.memsys.bus.cache import Cache
from hw.lib.payload import pack
from hw.memsys.patches.path_formats import BEATS, PathFormats, RequestKind
from tb.memsys.memory_path import scene_image

__all__ = ["BusScene"]

CELLS, ENTRIES, PATCHES = 20, 90, 24


class BusScene:
    """Cells with lists of up to two parts and patches.

    Members
    -------
    image, bases, counts
        Bytes, offsets of the tables in them, and what is in `PathFormats.scene`.
    """

    def __init__(self, config: Config):
        self._config, self._formats, draw = config, PathFormats(config), random.Random(4)
        self._cells = [(4 * k, draw.randrange(1, 9)) for k in range(CELLS)]
        self._lists = [draw.randrange(PATCHES) for _ in range(ENTRIES)]
        self._vertices = [[[draw.randrange(1 << 24) for _ in range(3)] for _ in range(4)] for _ in range(PATCHES)]
        self.image, self.bases = scene_image([a for a, _ in self._cells], [b for _, b in self._cells], self._lists,
                                             self._vertices, [0] * PATCHES)
        self.counts = {"cells": CELLS, "lists": ENTRIES, "patches": PATCHES}

    def requests(self, count: int, seed: int) -> list[tuple[int, RequestKind, int]]:
        """Clusters, kinds and keys, some of them often."""
        draw = random.Random(seed)
        kinds = list(RequestKind)
        drawn = []
        for _ in range(count):
            kind, cluster = draw.choice(kinds), draw.randrange(2)
            if kind is RequestKind.PATCH:
                key = draw.choice([draw.randrange(6), draw.randrange(PATCHES)])
            else:
                key = draw.choice([draw.randrange(4), draw.randrange(CELLS)])
                key |= draw.randrange(2) << self._formats.cell_bits
            drawn.append((cluster, kind, key))
        return drawn

    def entries(self, key: int) -> range:
        """The entries of the lists that a part of a cell is read from."""
        part, cell = divmod(key, 1 << self._formats.cell_bits)
        (pointer, count), ids = self._cells[cell], self._config.memsys.reply_ids
        return range(pointer + ids * part, pointer + min(count, ids * part + ids))

    def hits(self, mine: list[tuple[int, int]], policy: str, lines: int) -> np.ndarray:
        """Golden's, access by access, of one kind's (cluster, key) from an empty cache on."""
        memsys = self._config.replace({"memsys.cache_policy": policy}).memsys
        return Cache.of(memsys, lines=lines).access(np.array([key for _, key in mine]))[0]

    def reply(self, kind: RequestKind, cluster: int, key: int, hit, *, failed: bool = False) -> list[dict]:
        """The beats of a reply; one whose read ``failed`` has errors instead of data."""
        common = {"cluster": cluster, "kind": kind.value, "hit": int(hit)}
        if kind is RequestKind.PATCH:
            data = [None] * BEATS if failed else [key, *(
                sum(part << 24 * axis for axis, part in enumerate(one)) for one in self._vertices[key])]
        else:
            part, cell = divmod(key, 1 << self._formats.cell_bits)
            pointer, count = self._cells[cell]
            ids = self._config.memsys.reply_ids
            # A part behind the list's end is an error, or empty if the one before it was full.
            failed |= ids * part > count
            data = [] if failed else [
                pack(self._formats.cell_beat, {"number": entry, "is_id": 1, "more": ids * part + ids < count})
                for entry in self._lists[pointer:pointer + count][ids * part:ids * part + ids]]
            data = data or [None]
        return [{**common, "data": one, "last": int(number == len(data) - 1), "error": int(failed)}
                for number, one in enumerate(data)]
