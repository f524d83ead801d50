from hw.memsys.load.image_layout import PATCH_WORDS
from hw.memsys.load.patch_extents import PatchExtents
from tb.lib.bench import Bench
from tb.lib.shift_registers import ShiftRegisters

MOST, RECORD = 1 << PatchExtents.index_bits, 64


class TestPatchExtents(Bench):
    component, variants, span = PatchExtents, ({},), 1500
    # Offers of the first ids and of all extents at once take as many cycles.
    chances = ((1, 1), (0.9, 0.6), (0.5, 1))

    def model(self, config):
        """The records of the ids in their order; the next ones when the last extent has been taken."""
        ids, pipeline, index, count, self.busy = {}, ShiftRegisters(3), 0, 0, False
        base = 0
        given = yield
        while True:
            end, ready = pipeline.end, given.o
            outputs = {"i": not self.busy, "o": end and {
                "address": end["address"], "length": PATCH_WORDS - 1, "narrow": 0}}
            step = None
            if index < count:
                address = (base + RECORD * ids[index]) % (2 << config.memory.address_bits) if index in ids else None
                step = {"address": address, "last": index == count - 1}
                index += pipeline.advances(ready)
            pipeline.step(step, ready)
            if self.busy and end and ready:
                self.busy = not end["last"]
            elif not self.busy and given.i:
                base, count, index, self.busy = given.i["base"], given.i["count"], 0, True
            if given.i_id:
                ids[given.i_id["index"]] = given.i_id["id"]
            given = yield outputs

    def items(self, name, shape, random):
        """All ids first, then few; all of them, then few extents, an id at least."""
        for number, item in enumerate(super().items(name, shape, random)):
            if name == "i_id":
                yield item | ({"index": number} if number < MOST else {})
            else:
                yield item | {"count": random.randint(1, 7) if number % 8 else MOST}

    def drive(self, given, random):
        """No id comes while extents are given; those of ids that have not come are anywhere."""
        if self.busy:
            given.i_id = None
