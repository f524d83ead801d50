from collections import deque

from hw.memsys.load.image_layout import PATCH_WORDS, RECORD_WORDS, RULES, RegionNumber
from hw.memsys.load.record_words import RecordWords
from hw.memsys.port.fault import Fault
from tb.lib.bench import Bench
from tb.lib.shift_registers import ShiftRegisters

# Records of one word, of several, and of a patch, which has padding.
REGIONS = [RegionNumber.PATCHES, RegionNumber.RESIDENTS, RegionNumber.COLUMNS, RegionNumber.SHELLS]
READ = Fault.READ_REPLY.value
# Of a word that points into a table: which it is.
TABLES = {(rule.region, rule.word): rule.table for rule in RULES}


class TestRecordWords(Bench):
    component, variants = RecordWords, ({},)
    chances = Bench.chances * 2

    def model(self, config):
        """Words of one region are numbered from a record on; what is wrong with a word that was read is checked by
        `tb.memsys.load.test_table_check`.
        """
        pipeline, buffer, record, word, self.cycle = ShiftRegisters(4), deque(), 0, 0, 0
        given = yield
        while True:
            size = PATCH_WORDS if self.region is RegionNumber.PATCHES else RECORD_WORDS[self.region.value]
            end, accepts, item = pipeline.end, len(buffer) < 2, given.i
            outputs = {"i": pipeline.advances(accepts), "o": buffer[0] if buffer else None,
                       "table": item and TABLES.get((self.region.value, word), 0)}
            named = item and {"fault": READ if item["error"] else None, "last": item["last"], "item": {
                "region": self.region.value, "record": record, "word": word, "data": item["data"]}}
            if given.start:
                record, word = given.record, 0
            elif item and outputs["i"]:
                record, word = (record + (word == size - 1)) % (1 << 32), (word + 1) % size
            if buffer and given.o:
                buffer.popleft()
            if end and accepts:
                buffer.append(end)
            pipeline.step(named, accepts)
            self.cycle += 1
            given = yield outputs

    def drive(self, given, random):
        """A region and a first record are named before the first word; another one in the middle of a record too."""
        if self.cycle == 0:
            self.region = random.choice(REGIONS)
        given.region, given.limit = self.region.value, (1 << 32) - 1
        given.start = self.cycle == 1 or (self.cycle >= 3 and random.random() < 0.1)
        if self.cycle < 3 or given.start:
            given.i = None
