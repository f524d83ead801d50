"""Pointers and sizes: the last record, or what the machine has bits for, passes, and one more does not."""

import numpy as np

from golden.engine.memory_map import GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS, REGIONS, WEIGHT_BITS
from golden.engine.memory_map.rules import RULES, RuleKind
from hw.memsys.load.image_layout import PATCH_WORDS, RegionNumber, halves
from hw.memsys.load.table_check import TableCheck
from hw.memsys.port.fault import Fault
from tb.lib.bench import Bench
from tb.lib.cycles import any_value

MOST, WORD = (1 << 32) - 1, 8
POINTERS = RuleKind.BELOW, RuleKind.MAYBE, RuleKind.RANGE
LAYOUTS = {region.name: region.dtype for region in REGIONS}


class TestTableCheck(Bench):
    component, arguments, variants, span = TableCheck, {"tag": 2}, ({},), 400

    def model(self, config):
        """Four registers that stall together; a word has the fault of its record that is known with it."""
        stages = [None] * 4
        given = yield
        while True:
            advances, word = stages[-1] is None or given.o, given.i
            outputs = {"i": advances, "o": stages[-1], "table": word and self.table}
            if advances:
                stages = [word and word | {"fault": self.fault}, *stages[:-1]]
            given = yield outputs

    def items(self, name, shape, random):
        """The words of records, each with the rule that ends in it."""
        for item in super().items(name, shape, random):
            region = random.choice([*LAYOUTS, *(rule.region for rule in RULES)])
            record, limits = drawn(region, random)
            data = record.tobytes()
            for number in range(PATCH_WORDS if region == "patches" else -(-len(data) // WORD)):
                self.table, self.limit, self.fault = None, item["item"]["record"], Fault.NONE.value
                for rule in RULES:
                    if rule.region == region and number in words_of(rule):
                        if rule.kind in POINTERS:
                            self.table, self.limit = RegionNumber[rule.table.upper()].value, limits[rule.table]
                        if not holds(rule, number, record, limits):
                            self.fault = Fault[rule.kind.code].value
                yield {"tag": item["tag"], "item": item["item"] | {
                    "region": RegionNumber[region.upper()].value, "word": number,
                    "data": int.from_bytes(data[WORD * number:WORD * (number + 1)], "little")}}

    def drive(self, given, random):
        """Records of the region that the word points into."""
        if given.i:
            given.limit = self.limit


class Records:
    """One record of a table, which has many."""

    def __init__(self, record, count):
        self._record, self._count = record, count

    def __getitem__(self, name):
        return self._record[name]

    def __len__(self):
        return self._count


def drawn(region, random):
    """A record at the limits of its rules, and the numbers of records of the tables that it points into."""
    record, limits = np.frombuffer(random.randbytes(LAYOUTS[region].itemsize), dtype=LAYOUTS[region]).copy(), {}
    for name in {"reserved", "padding"} & LAYOUTS[region].fields.keys():
        record[name] = 0
    # The sizes of a shell are in other rules too.
    for rule in sorted((rule for rule in RULES if rule.region == region), key=lambda rule: rule.kind in POINTERS):
        near = random.choice((-1, 0, 0, 1))
        if rule.kind is RuleKind.SMALL:
            record["shape"] = [random.choice((1, 1, 1, (1 << GRID_SHAPE_BITS) + near, 1 << 31)) for _ in range(3)]
        elif rule.kind is RuleKind.WEIGHT:
            record["weight"] = random.choice((1 << WEIGHT_BITS + 20, max(0, (1 << WEIGHT_BITS) + near)))
        elif rule.kind is RuleKind.QUAD:
            record["kind"] = random.choice((0, 0, 1, 128, 255))
        elif rule.kind is RuleKind.GRID:
            rows, columns = random.choices((0, 1, 3, 1023, 1024, (1 << GRID_SIDE_BITS) + near, 1 << 31), k=2)
            record["rows"], record["columns"] = rows, columns
            record["first_ray"] = random.choice((MOST, max(0, (1 << GRID_RAY_BITS) - rows * columns + near)))
        else:
            for name in set(rule.fields) - {"rows", "columns"}:
                record[name] = np.array(any_value(32, random) >> random.choice((0, 0, 1, 29)), dtype="<u4").view("<i4")
            end = sum(int(record[name][0]) & MOST for name in rule.fields)
            # Of clusters there are never so many that an index has the sign of those that are none.
            most = MOST >> (rule.kind is RuleKind.MAYBE)
            limits[rule.table] = random.choice((min(most, max(0, end + near)), most))
    return record, limits


def words_of(rule):
    """The words in which a rule is known to be broken: the last one of its fields, and behind a high half the next."""
    if rule.kind is RuleKind.SMALL:
        return {word for word, _ in halves(rule.region, *rule.fields)}
    at = LAYOUTS[rule.region].fields[rule.fields[-1 if rule.kind is RuleKind.RANGE else 0]][1]
    return {at // WORD + (rule.kind in (RuleKind.BELOW, RuleKind.MAYBE) and at % WORD != 0)}


def holds(rule, word, record, limits):
    """Whether golden's rule holds, for the elements of a word."""
    given = record.copy()
    if rule.kind is RuleKind.SMALL:
        given["shape"] = [value if at == word else 0 for value, (at, _) in zip(
            given["shape"][0], halves(rule.region, "shape"), strict=True)]
    return bool(rule.holds({rule.region: Records(given, len(record))} | {
        rule.table: Records(given, limits.get(rule.table, 1))})[0])
