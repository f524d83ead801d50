import random
from itertools import pairwise

from amaranth.hdl import Shape

from hw.icu.icu_formats import IcuFormats
from hw.icu.patch_slots import PatchSlots
from hw.lib.payload import unpack
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = config_of({"icu.slots": 16})
PARTS = {name: field.shape for name, field in IcuFormats(CONFIG).slot_record}
READS, WRITES = 300, 80
SEED = 4


def drawn(generator, shape):
    """A random value of a shape."""
    return unpack(shape, generator.getrandbits(Shape.cast(shape).width))


def test_a_part_can_be_read_in_the_cycle_after_it_was_written():
    """Reads in every cycle, writes of all parts beside them, each part on its own."""
    slots, generator = PatchSlots(config=CONFIG, tag=10), random.Random(SEED)
    assert slots.latency == documented_latency(PatchSlots, CONFIG)
    bench = ScheduleBench(slots, [*(f"i_{name}" for name in PARTS), "i"], ["o"])
    # All slots of all parts first, then any of them.
    order = [*range(CONFIG.icu.slots), *(generator.randrange(CONFIG.icu.slots) for _ in range(WRITES))]
    writes = {name: [(generator.choice((0, 0, 2, 5)) * (k >= CONFIG.icu.slots), {"slot": slot, "part": drawn(
        generator, shape)}) for k, slot in enumerate(order)] for name, shape in PARTS.items()}
    reads = [((CONFIG.icu.slots + 1) * (k == 0), {"tag": k, "slot": generator.randrange(CONFIG.icu.slots)})
             for k in range(READS)]
    schedule = Schedule(items={**{f"i_{name}": items for name, items in writes.items()}, "i": reads}, stalls={})
    came, cycles = bench.run(schedule)["o"], bench.cycles
    assert [item["tag"] for item in came] == list(range(READS))
    assert {b - a for a, b in pairwise(cycles["i"])} == {1}
    assert {made - given for given, made in zip(cycles["i"], cycles["o"], strict=True)} == {slots.latency}

    coverage = Coverage([f"{name} read {when}" for name in PARTS for when in ("a cycle after", "later")])
    for name in PARTS:
        written = list(zip(cycles[f"i_{name}"], (write for _, write in writes[name]), strict=True))
        for cycle, (_, read), made in zip(cycles["i"], reads, came, strict=True):
            mine = [(cycle - at, write["part"]) for at, write in written if write["slot"] == read["slot"]]
            if any(age == 0 for age, _ in mine):
                # Who hands out the slots sees to it that this does not happen.
                continue
            age, part = [(age, part) for age, part in mine if age > 0][-1]
            assert made["record"][name] == part, (name, read, age)
            coverage.hit(f"{name} read " + ("a cycle after" if age == 1 else "later"))
    coverage.check()
