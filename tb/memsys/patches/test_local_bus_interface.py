"""Requests of a cluster and replies to it, good ones and lost ones."""

from collections import deque

from hw.formats import Formats
from hw.lib.payload import pack, unpack
from hw.memsys.patches.local_bus_interface import LocalBusInterface
from hw.memsys.patches.path_formats import BEATS, PathFormats, RequestKind
from tb.lib.bench import Bench
from tb.lib.grants import RoundRobin

IDS, REQUESTS = 2, 2
CELL, PATCH = RequestKind.CELL.value, RequestKind.PATCH.value
VERTICES = BEATS - 1


class TestLocalBusInterface(Bench):
    component, variants, span = LocalBusInterface, ({},), 500
    changes = {"memsys.reply_ids": IDS, "memsys.bus_requests": REQUESTS, "noc.columns": 2}

    def model(self, config):
        """Further parts of a list come before other cells, but not before one that is offered already."""
        formats, vertex = PathFormats(config), Formats(config).patch_vertex["vertex"].shape
        rule, request, offers_cell, cells, patches = RoundRobin(), None, False, 0, 0
        further, requested, entries, vertices = deque(), deque(), deque(), deque()
        beat = index = hits = misses = 0
        lost_cell = lost_patch = head = None
        # What is to be answered, for `items`.
        self.outstanding, self.beats = {CELL: deque(), PATCH: deque()}, {CELL: [], PATCH: []}
        given = yield
        while True:
            is_further = bool(further) and not offers_cell
            cell = given.i_cell if cells < REQUESTS else None
            offers = {0: further[0] if is_further else (cell, 0)} if further or cell is not None else {}
            offers |= {1: given.i_patch} if given.i_patch is not None and patches < REQUESTS else {}
            granted = rule.grant(offers, offers) if request is None or given.o_request else None
            entry, corner, reply = next(iter(entries), None), next(iter(vertices), None), given.i_reply
            ends = entry and entry["last"]
            more = ends and entry["item"]["more"] and not entry["error"]
            outputs = {
                "i_cell": granted == 0 and not is_further, "i_patch": granted == 1, "o_request": request,
                "o_listed": entry and {"item": entry["item"], "last": int(ends and not more)},
                "o_vertex": corner["vertex"] if corner and not corner["error"] else None,
                "lost_cell": lost_cell is not None, "cell": lost_cell, "lost_patch": lost_patch is not None,
                "patch": lost_patch, "hits": hits, "misses": misses}

            if request and given.o_request:
                self.outstanding[request["kind"]].append(request["key"])
                request = None
            offers_cell = 0 in offers and granted != 0 and not is_further
            if granted is not None:
                rule.accept(granted)
                request = {"kind": PATCH, "key": offers[1]} if granted else {
                    "kind": CELL, "key": offers[0][0] | offers[0][1] << formats.cell_bits}
            if granted == 0:
                requested.append(offers[0])
                cells += not is_further
                if is_further:
                    further.popleft()
            patches += granted == 1
            lost_cell = lost_patch = None
            if entry and given.o_listed:
                entries.popleft()
                if ends:
                    number, part = requested.popleft()
                    lost_cell = number if entry["error"] else None
                    cells -= not more
                    if more:
                        further.append((number, part + 1))
            if corner and (corner["error"] or given.o_vertex):
                vertices.popleft()
                index = (index + 1) % VERTICES
                patches -= index == 0
                lost_patch = corner["vertex"]["patch"] if index == 0 and corner["error"] else None
            if reply and reply["kind"] == CELL:
                entries.append({"item": unpack(formats.cell_beat, reply["data"]), **{
                    name: reply[name] for name in ("last", "error")}})
            elif reply and beat == 0:
                head, beat, hits, misses = unpack(formats.patch_head, reply["data"]), 1, (
                    hits + reply["hit"]), misses + 1 - reply["hit"]
                error = reply["error"]
            elif reply:
                vertices.append({"vertex": {**head, "vertex": unpack(vertex, reply["data"])}, "error": error})
                beat = (beat + 1) % BEATS
            given = yield outputs

    def items(self, name, shape, random):
        """Replies to what has been requested, a third of them errors."""
        if name != "i_reply":
            yield from super().items(name, shape, random)
        while True:
            kinds = [kind for kind in (CELL, PATCH) if self.outstanding[kind] or self.beats[kind]]
            if not kinds:
                yield None
                continue
            kind = random.choice(kinds)
            if not self.beats[kind]:
                self.beats[kind] = self._reply(kind, self.outstanding[kind].popleft(), random)
            data, last, error = self.beats[kind].pop(0)
            yield {"cluster": random.getrandbits(1), "kind": kind, "last": int(last), "error": int(error),
                   "hit": random.getrandbits(1), "data": data}

    def _reply(self, kind, key, random):
        """Data of beats, which is the last one, and whether it is an error."""
        formats, error = PathFormats(self.config()), random.random() < 0.3
        if kind == PATCH:
            data = [pack(formats.patch_head, {"patch": key, "surface": random.getrandbits(16)}), *(
                random.getrandbits(formats.vertex_bits) for _ in range(VERTICES))]
        else:
            count = 1 if error else random.randint(1, IDS)
            more = random.random() < 0.5 and key >> formats.cell_bits < 2
            data = [pack(formats.cell_beat, {
                "number": random.getrandbits(formats.listed_bits), "is_id": int(not error and random.random() < 0.8),
                "more": int(more and number == count - 1)}) for number in range(count)]
        return [(one, number == len(data) - 1, error) for number, one in enumerate(data)]
