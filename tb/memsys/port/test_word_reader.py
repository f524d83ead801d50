from collections import deque

from hw.memsys.port.word_reader import WordReader
from tb.lib.bench import Bench


class TestWordReader(Bench):
    component, changes, span = WordReader, {"memory.length_bits": 2}, 400
    variants = [{"memory.data_bits": bits} for bits in (64, 128, 256, 512)]

    def model(self, config):
        """All beats of an extent, as many as there may be in each request; the words of the beats that come."""
        size, most = config.memory.beat_bytes, 1 << config.memory.length_bits
        depth, extents, beats, at, self.outstanding = max(2, config.memory.outstanding), deque(), None, None, 0
        given = yield
        while True:
            reply, extent, word = given.i_reply, extents[0] if extents else None, None
            accepts = beats is None and len(extents) < depth
            if extent:
                width = 4 if extent["narrow"] else 8
                address, left = at or (extent["address"], extent["length"])
                ends = left == 0 or address % size == size - width
                word = reply and {"last": int(left == 0), "error": reply["error"],
                                  "data": reply["data"] >> 8 * (address % size) & (1 << 8 * width) - 1}
            outputs = {
                "i": accepts, "o": word, "i_reply": given.o and extent is not None and ends,
                "o_request": None if beats is None else {
                    "address": size * beats[0], "length": min(most, beats[1] + 1) - 1, "tag": 0}}
            if word and given.o:
                at = (address + width, left - 1)
                if left == 0:
                    at = None
                    extents.popleft()
            if beats and given.o_request:
                first, further = beats
                self.outstanding += min(most, further + 1)
                beats = (first + most, further - most) if further >= most else None
            if given.i and accepts:
                extents.append(given.i)
                first, width = given.i["address"] // size, 4 if given.i["narrow"] else 8
                beats = first, (given.i["address"] + width * given.i["length"]) // size - first
            given = yield outputs

    def items(self, name, shape, random):
        """Extents of some beats at any word, many at the end of memory; beats that have been requested, some of them
        errors.
        """
        for item in super().items(name, shape, random):
            if name == "i":
                width = 4 if item["narrow"] else 8
                top = 1 << shape["address"].width - 1
                address = random.choice((item["address"], -(item["address"] % 64))) % top
                yield item | {"length": random.randrange(22), "address": address // width * width}
            else:
                yield item if self.outstanding else None
                self.outstanding -= self.outstanding > 0
