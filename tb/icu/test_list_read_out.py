import numpy as np

from golden.engine.jobs.result_formats import pack_bits
from hw.icu.list_read_out import ListReadOut
from tb.lib.bench import Bench
from tb.lib.cycles import any_value
from tb.lib.registers import Registers

# Around one word and several; all that there is room for; reads that may be outstanding.
COUNTS, FULL, OUTSTANDING = (1, 2, 63, 64, 65, 128, 130), 256, 16
# At the end of a part only lists come: the reset is within one.
UNREAD = 40


class TestListReadOut(Bench):
    """The list of one bank is read out again and again while that of the other one comes."""

    component, span, filled = ListReadOut, 2 * FULL + 20 + UNREAD, False
    changes, variants = {"icu.shadow_bits": 8}, ({}, {"icu.rays": 256, "icu.side_bits": 6})

    def model(self, config):
        """Two cycles from a ray's address to its read; a reply is taken when its word, if it is full, can leave."""
        self.complete, self.writing, self.claimed, self.kept, self.busy = set(), None, None, None, False
        self.left, self.bank, lists, rays, pipe, outstanding = self.span, 0, [[], []], [], Registers(2), []
        bits, index, word = [], 0, None
        given = yield
        while True:
            place = pipe[0]
            read = {"bank": self.bank, "ray": place[0]} if place and len(outstanding) < OUTSTANDING else None
            free = word is None or given.o
            outputs = {"busy": int(self.busy), "bank": self.bank, "i": not self.busy, "o_read": read, "o": word,
                       "i_hit": bool(outstanding) and free}
            takes, reads = given.i_hit is not None and outputs["i_hit"], read is not None and given.o_read
            begins = given.i is not None and not self.busy
            if word is not None and given.o:
                self.busy, index, word = not word["last"], 0 if word["last"] else index + 1, None
            if takes:
                is_ray, last = outstanding.pop(0)
                bits.append(is_ray and given.i_hit["inverse"] > 0)
                if last or len(bits) == 64:
                    word = {"index": index, "word": int.from_bytes(pack_bits(np.array(bits)), "little"), "last": last}
                    bits = []
            if reads:
                outstanding.append(place[1:])
            pipe.step(rays.pop(0) if rays and pipe.moves(reads) else None, reads)
            if begins:
                self.busy, self.bank, self.claimed = True, given.i["bank"], None
                rays = [*lists[self.bank]]
            self.store(given.i_ray, lists)
            self.left -= 1
            given = yield outputs

    def store(self, one, lists):
        """A ray at the end of its bank's list."""
        if one is not None:
            if one["bank"] != self.writing:
                self.writing, lists[one["bank"]] = one["bank"], []
                self.complete.discard(one["bank"])
            lists[one["bank"]].append((one["ray"], one["is_ray"], one["last"]))
            if one["last"]:
                self.complete.add(one["bank"])
                self.writing = None

    def items(self, name, shape, random):
        """Lists of banks that are not read, the first one full; reads of those whose list has come. Hits are all or
        nothing.
        """
        if name == "i_ray":
            while True:
                banks = [bank for bank in range(2) if bank not in (self.claimed, self.kept)
                         and not (self.busy and bank == self.bank)]
                if not banks:
                    yield None
                    continue
                bank, count = random.choice(banks), random.choice((*COUNTS, random.randint(1, FULL)))
                if not self.filled:
                    count, self.kept, self.filled = FULL, bank, True
                self.complete.discard(bank)
                for k in range(count):
                    yield any_value(shape, random) | {"bank": bank, "last": int(k == count - 1)}
        while name == "i":
            if self.complete and self.left > UNREAD:
                self.claimed = random.choice([*self.complete])
                self.kept = None if self.claimed == self.kept else self.kept
                yield {"bank": self.claimed}
            else:
                yield None
        while True:
            hit = any_value(shape, random)
            yield hit | {"inverse": random.choice((0, (1 << shape["inverse"].width) - 1))}
