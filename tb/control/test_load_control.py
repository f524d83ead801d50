"""Loads, with units that take their time."""

import random
from itertools import count

import pytest

from golden.engine.config import PRESETS
from golden.engine.memory_map import REGIONS
from hw.control.load_control import ALL, LoadControl
from hw.memsys.load.image_layout import RegionNumber
from hw.memsys.load.preload_dma import OWN
from hw.memsys.port.fault import Fault
from tb.lib.bench import Bench, Vectors
from tb.lib.responder import Responder, responder
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"noc.columns": 4, "noc.rows": 1})
NODES, WORDS = 4, 4


def word(image, number):
    """A word of a table."""
    return {"region": RegionNumber.CELLS.value, "record": image >> 6 & 0xFFFF, "word": number, "data": image}


class TestLoadControl(Bench):
    """Loads one after the other, of images that fail at each cluster, or are at no multiple of 64."""

    component = LoadControl
    # The last node is a patch node: it has tables too.
    changes = {"noc.columns": NODES, "noc.rows": 1, "noc.patch_nodes": 1}
    variants = [{}]

    @staticmethod
    def fault(image, cluster):
        """How the DMA ends a command."""
        code = Fault.POINTER if image // 64 % (NODES + 2) == cluster else Fault.NONE
        return {"code": code.value, "address": image + cluster + 8}

    @responder("o_command", "i_word", after=(0, 9))
    def words(self, command):
        """The DMA."""
        self.command = command
        return [word(command["image"], number) for number in range(WORDS)]

    @responder("o_word", "i_done", after=(0, 9))
    def done(self, word):
        """It is done after its last word."""
        return [self.fault(self.command["image"], self.command["cluster"])] if word["item"]["word"] == WORDS - 1 else []

    def vectors(self, config):
        return self.drawn(config, 0)

    def drawn(self, config, seed):
        draw, loads, commands, words, overs = random.Random(seed), [], [], [], []
        for number in range(14):
            image = 64 * draw.getrandbits(config.memory.address_bits - 8)
            wrong = draw.choice((1, 32, 1 << config.memory.address_bits, 1 << 63)) if number % 7 == 3 else 0
            regions, copies = draw.choice((ALL, ALL & ~OWN, OWN, draw.getrandbits(len(REGIONS)))), draw.randrange(2)
            loads.append({"image": image + wrong, "regions": regions, "copies": copies})
            steps = [(0, regions if copies else regions & ~OWN)]
            if regions & OWN and not copies:
                steps += [(cluster, regions & OWN) for cluster in range(NODES)]
            over = {"code": Fault.IMAGE.value, "address": (image + wrong) % (1 << config.memory.address_bits)}
            for step, (cluster, some) in enumerate(steps if not wrong else ()):
                commands.append({"image": image, "cluster": cluster, "regions": some})
                # The shared tables, or copies, are for all.
                words += [{"item": word(image, k), "cluster": cluster, "is_all": step == 0} for k in range(WORDS)]
                over = self.fault(image, cluster)
                if over["code"]:
                    break
            # The address has a meaning if there is a fault.
            overs.append(over if over["code"] else {**over, "address": None})
        return Vectors(inputs={"i": loads}, ports={"stored": 1},
                       expected={"o_command": commands, "o_word": words, "o_over": overs})

    def predict(self, given, trace, component, config):
        """A word passes in its own cycle; the DMA decides when a command ends."""
        return {"o_word": trace.cycles["i_word"]}


@pytest.mark.parametrize("copies", [0, 1])
@pytest.mark.parametrize("regions", [ALL, ALL & ~OWN], ids=["all", "shared"])
def test_a_step_of_a_load_ends_when_its_word_is_stored(regions, copies):
    """Soon after the 60 cycles of each word, and then the next one begins, or the unit is idle."""
    bench, cycle = ScheduleBench(LoadControl(config=CONFIG), idle_limit=80, watched=["busy"]), count(1)
    bench.run(
        Schedule(items={"i": [(0, {"image": 64, "regions": regions, "copies": copies})]}),
        Responder("o_command", "i_word", lambda command: [word(command["image"], 0)]),
        Responder("o_word", "i_done", lambda word: [{"code": Fault.NONE.value, "address": 0}]),
        stored=lambda cycles: int(next(cycle) - (cycles["i_word"] or [-60])[-1] >= 60))
    words, commands, (begin,), (end,) = (bench.cycles[name] for name in ("i_word", "o_command", "i", "o_over"))
    assert len(words) == len(commands) == (1 if copies or not regions & OWN else 1 + NODES)
    for stored, ends in zip(words, [*commands[1:], end], strict=True):
        assert 60 <= ends - stored <= 64
    busy = [cycle for cycle, is_busy in enumerate(bench.history["busy"], start=1) if is_busy]
    assert busy == [*range(begin + 1, end + 1)]
    assert commands[0] - begin == documented_latency(LoadControl, CONFIG)
