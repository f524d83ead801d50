"""What the caches fetch: lists in parts and patches, from a memory that is late; malformed tables and errors."""

import random
from collections import defaultdict
from dataclasses import dataclass

from golden.engine.config import Config
from hw.lib.payload import pack
from hw.memsys.bus.cell_fetch import CellFetch
from hw.memsys.bus.patch_fetch import PATCH_WORDS, PatchFetch
from hw.memsys.patches.path_formats import BEATS, PathFormats
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import config_of
from tb.lib.responder import responder
from tb.memsys.memory_path import scene_image

CHANGES = {"memsys.reply_ids": 4, "memsys.cache_fetches": 4, "icu.patch_bits": 8}
CONFIG = config_of(CHANGES)
FORMATS, WIDTH, FETCHES = PathFormats(CONFIG), CONFIG.numbers.scene.width, CONFIG.memsys.cache_fetches
BASE, NONE = 0x1240, (1 << 32) - 1
# An error in any beat; and such that no beat of a part is an entry.
ERROR, WRONG = "error", "wrong"


@dataclass(frozen=True)
class Memory:
    """The tables, the offsets of words that cannot be read, and of all fetches the records, or `ERROR` or `WRONG`, and
    the entries of the list that are read, None if no record is.
    """

    image: bytes
    fails: list
    records: list
    entries: list

    def beats(self, request):
        """The reply to a request."""
        offsets = [request["address"] - BASE + 8 * k for k in range(request["length"] + 1)]
        assert 0 <= offsets[0] <= offsets[-1] <= len(self.image) - 8, f"{request} is outside the image"
        return [{"data": int.from_bytes(self.image[at:at + 8], "little"), "tag": 0, "last": int(at == offsets[-1]),
                 "error": int(at in self.fails)} for at in offsets]


class Fetches(Bench):
    """Records are put together in the order of the fetches, each slot's beats in theirs."""

    changes, variants, splits, idle_limit, cycles = CHANGES, ({},), False, 60, 100_000
    records_at, size = "o_request", BEATS

    def of(self, keys, ports, memory):
        """Vectors of some keys."""
        return Vectors(inputs={"i": [{"slot": number % FETCHES, "key": key} for number, key in enumerate(keys)]},
                       expected={"o": [None] * (self.size * len(keys))}, ports=ports, about=memory)

    def check(self, given, came):
        fills, memory = self.values("o", came), given.about
        assert len(fills) == self.size * len(memory.records)
        assert len(came[self.records_at]) == len(given.inputs["i"]) - memory.entries.count(None)
        for number, record in enumerate(memory.records):
            beats = fills[self.size * number:self.size * (number + 1)]
            assert [(one["slot"], one["beat"]) for one in beats] == [(number % FETCHES, k) for k in range(self.size)]
            assert any(one["error"] for one in beats) == (record in (ERROR, WRONG)), given.inputs["i"][number]
            if record == WRONG:
                assert not any(one["data"]["is_id"] for one in beats)
            elif record != ERROR:
                assert [self.known(one["data"]) for one in beats] == record

    def known(self, data):
        """What is known of the data of a beat."""
        return data

    def predict(self, given, trace, component, config):
        """A fetch waits for an entry of the queue, and a record for the request of the one before."""
        found, passed, requested, left = defaultdict(list), 0, 0, [0] * FETCHES
        fill = self.fill(given, trace, found)
        next(fill)
        for number, offered in enumerate(trace.offered["i"]):
            found["i"].append(max(offered, passed))
            exists = given.about.entries[number] is not None
            passed = max(found["i"][-1], left[-FETCHES], requested if exists else 0) + 1
            if exists:
                requested = trace.ready(self.records_at, passed + 1)
                found[self.records_at].append(requested)
            left.append(fill.send((number, passed)))
        return found


def patches(draw, count):
    return [[[draw.randrange(1 << WIDTH) for _ in range(3)] for _ in range(4)] for _ in range(count)]


class TestPatchFetch(Fetches):
    component = PatchFetch

    @responder("o_request", "i_reply", after=(0, 9))
    def memory(self, request):
        return self.now.about.beats(request)

    def vectors(self, config: Config):
        draw, count = random.Random(5), 20
        vertices, surface = patches(draw, count), [draw.randrange(-3, 1 << 20) for _ in range(count)]
        image, bases = scene_image([], [], [], vertices, surface)
        image = bytearray(image)
        # Patch 7 says that it is patch 8; of patch 9 a beat cannot be read.
        image[bases["patches"] + 7 * 64] = 8
        keys = [3, 19, 0, 7, 20, 9, 255, 4, 3, 1, 2, 5]
        records = [ERROR if key in (7, 9) or key >= count else [
            pack(FORMATS.patch_head, {"patch": key, "surface": surface[key]}),
            *(sum(part << WIDTH * axis for axis, part in enumerate(one)) for one in vertices[key])] for key in keys]
        return self.of(keys, {"base": BASE + bases["patches"], "count": count}, Memory(
            bytes(image), [bases["patches"] + 9 * 64 + 32], records,
            [range(0) if key < count else None for key in keys]))

    def fill(self, given, trace, found):
        """A word per cycle, and a beat for each but word 1."""
        replies, word = iter(trace.offered["i_reply"]), 0
        number, passed = yield
        while True:
            word = max(word, passed)
            for index in range(PATCH_WORDS):
                word += 1
                if given.about.entries[number] is not None:
                    word = max(word, next(replies))
                    found["i_reply"].append(word)
                if index != 1:
                    found["o"].append(word)
            number, passed = yield word


class TestCellFetch(Fetches):
    component, records_at, size = CellFetch, "o_request__0", CONFIG.memsys.reply_ids

    @responder("o_request__0", "i_reply__0", after=(0, 9))
    def cells(self, request):
        return self.now.about.beats(request)

    @responder("o_request__1", "i_reply__1", after=(0, 9))
    def lists(self, request):
        return self.now.about.beats(request)

    @property
    def cases(self):
        return {"parts": self.parts, "parts that cannot be named": self.long_lists}

    def known(self, data):
        return data if data["is_id"] else {**data, "number": None}

    def fill(self, given, trace, found):
        """A record, three cycles, the request for its entries; an entry per cycle, of which a beat has two."""
        records, lists = (iter(trace.offered[f"i_reply__{k}"]) for k in range(2))
        request = word = passes = 0
        left = [0] * FETCHES
        number, passed = yield
        while True:
            entries = given.about.entries[number]
            read = max(passed, passes) + 1
            if entries is not None:
                read = max(read, next(records))
                found["i_reply__0"].append(read)
            passes = max(read + 3, left[-FETCHES] + 1)
            if entries:
                request = trace.ready("o_request__1", max(passes, request) + 2)
                found["o_request__1"].append(request)
            word = max(word, passes)
            for index in range(self.size):
                word += 1
                if entries and index < len(entries):
                    if not index or entries[index] % 2 == 0:
                        reply = next(lists)
                    word = max(word, reply)
                    if entries[index] % 2 or index == len(entries) - 1:
                        found["i_reply__1"].append(word)
                found["o"].append(word)
            left.append(word)
            number, passed = yield passes

    def of_cells(self, keys, image, bases, records, entries, *, cells, lists, names, fails=()):
        """Vectors of parts of lists; ``names``: patches that there are."""
        return self.of(keys, {"cells_base": BASE + bases["cells"], "lists_base": BASE + bases["lists"],
                              "scene": {"cells": cells, "lists": lists, "patches": names}},
                       Memory(image, fails, records, entries))

    def parts(self, config: Config):
        """Lists here, beyond, empty, and such that cannot be; entries that name no patch."""
        draw, names = random.Random(6), 200
        lists = [draw.randrange(names) for _ in range(60)]
        lists[21], lists[30] = names, NONE
        cells = [(0, 0), (60, 0), (0, 4), (1, 4), (3, 1), (59, 1), (2, 9), (20, 12), (0, 61), (61, 0), (58, 3),
                 (NONE, 2), (3, NONE), (30, 1), (7, 5), (0, 60)]
        # Of every other one the only word cannot be read; its reply may wait while the beats before it are filled up.
        cells += [(2 if k % 2 else 50 + k, 1) for k in range(8)]
        image, bases = scene_image([a & NONE for a, _ in cells], [b for _, b in cells], lists, patches(draw, 1), [0])
        keys = [{"cell": 3, "part": 0}]
        keys += [{"cell": cell, "part": part} for cell, (pointer, count) in enumerate(cells) for part in range(
            max(1, -(-count // 4)) if pointer + count <= 60 else 1)]
        keys += [{"cell": len(cells), "part": 0}, {"cell": 2, "part": 3}, {"cell": 6, "part": 200}]
        fails = [bases["cells"] + 8 * 4, (bases["lists"] + 4 * 3) & ~7]

        def record(cell, part):
            pointer, count = cells[cell] if cell < len(cells) else (0, 0)
            first, end = pointer + 4 * part, min(pointer + count, pointer + 4 * part + 4)
            if cell >= len(cells) or pointer + count > len(lists) or 4 * part > count or cell == 4:
                return WRONG
            if any((bases["lists"] + 4 * entry) & ~7 in fails for entry in range(first, end)):
                return ERROR
            numbers = [lists[entry] if lists[entry] < names else 256 for entry in range(first, end)]
            return [{"number": number, "is_id": int(number is not None), "more": int(end < pointer + count)}
                    for number in [*numbers, *[None] * 4][:4]]

        def entries(cell, part):
            if cell >= len(cells) or record(cell, part) == WRONG:
                return range(0) if cell < len(cells) else None
            pointer, count = cells[cell]
            return range(pointer + 4 * part, min(pointer + count, pointer + 4 * part + 4))

        return self.of_cells(keys, image, bases, [record(**key) for key in keys], [entries(**key) for key in keys],
                             cells=len(cells), lists=len(lists), names=names, fails=fails)

    def long_lists(self, config: Config):
        """Without an error the part behind the last one that can be named would be the first one again."""
        parts = 1 << FORMATS.part_bits
        count = 4 * parts
        image, bases = scene_image([0, 0], [count, count + 1], [0] * (count + 1), patches(random.Random(1), 1), [0])
        keys = [{"cell": cell, "part": part} for cell in range(2) for part in (parts - 2, parts - 1)]
        first, last = ([{"number": 0, "is_id": 1, "more": more}] * 4 for more in (1, 0))
        entries = [range(count - 8, count - 4), range(count - 4, count), range(count - 8, count - 4), range(0)]
        return self.of_cells(keys, image, bases, [first, last, first, ERROR], entries, cells=2, lists=count + 1,
                             names=1)
