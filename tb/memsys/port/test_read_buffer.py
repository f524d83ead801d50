from hw.memsys.port.read_buffer import ReadBuffer
from tb.lib.bench import Bench


class TestReadBuffer(Bench):
    component, variants = ReadBuffer, ({},)
    changes = {"memory.outstanding": 4, "memory.burst_beats": 4}

    def model(self, config):
        """Bursts by slot: a beat that is expected is counted, and stored unless it is one too many, a cycle later."""
        slots, most = config.memory.outstanding, config.memory.burst_beats
        self.missing, wrong, self.length, self.came = ([0] * slots for _ in range(4))
        content, read, self.beat, early = {}, None, None, False
        given = yield
        while True:
            beat, slot = self.beat, self.beat and self.beat["id"]
            known = beat is not None and not early and self.missing[slot]
            stored = known and self.came[slot] <= self.length[slot]
            miscounted = known and (not stored or beat["last"] != (self.came[slot] == self.length[slot]))
            failed = beat is not None and beat["response"] >= 2
            outputs = {
                "outstanding": number(self.missing), "wrong": number(wrong), "beat_slot": slot, "stored": int(stored),
                "unexpected": int(beat is not None and (not known or miscounted)), "failed": int(failed),
                "port__data": read}
            address = slot * most + self.came[slot] if stored else None
            if given.port__en:
                # Of a beat that is stored in the same cycle nothing is said.
                read = content.get(given.port__addr) if given.port__addr != address else None
            if stored:
                content[address] = beat["data"]
            if known:
                self.came[slot] += 1
                self.missing[slot] &= not beat["last"]
                wrong[slot] |= failed or miscounted
            if given.start:
                self.missing[given.slot], wrong[given.slot] = 1, 0
                self.length[given.slot], self.came[given.slot] = given.length, 0
            self.beat = given.i
            # Memory cannot answer before it has accepted the address.
            early = given.i is not None and given.i["id"] in (
                *[given.slot] * given.start, *[given.offered_slot] * given.offered)
            given = yield outputs

    def items(self, name, shape, random):
        """Most are of a burst that misses beats, and the last one of it says so."""
        for item in super().items(name, shape, random):
            waits = [slot for slot, missing in enumerate(self.missing) if missing]
            slot = random.choice(waits) if waits and random.random() < 0.9 else item["id"]
            number = self.came[slot] + (self.beat is not None and self.beat["id"] == slot)
            last = number == self.length[slot] if random.random() < 0.85 else item["last"]
            yield item | {"id": slot, "last": int(last), "response": random.choice((0, 0, 0, 0, 1, item["response"]))}

    def drive(self, given, random):
        """A burst begins in a free slot; rarely memory is late to accept an address, mostly the latest burst's."""
        given.start &= not self.missing[given.slot]
        given.offered = int(random.random() < 0.15)
        given.offered_slot = random.choice((given.slot, given.offered_slot))


def number(bits):
    """The first one is the lowest bit."""
    return sum(bit << place for place, bit in enumerate(bits))
