"""Loads, with units that take their time."""

import random

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from golden.memory_map import REGIONS
from hw.control.load_control import ALL, LoadControl
from hw.memsys.fault import Fault
from hw.memsys.image_layout import RegionNumber
from hw.memsys.preload_dma import OWN
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.responder import responder
from tb.lib.runner import IN_A_COMMIT
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"noc.columns": 4, "noc.rows": 1})
CLUSTERS = 4


class TestLoadControl(Bench):
    """Loads one after the other, of images that fail at each cluster, or are at no multiple of 64."""

    component = LoadControl
    changes = {"noc.columns": CLUSTERS, "noc.rows": 1}
    variants = [{}]
    # One testbench of the control's in Verilator in every commit.
    simulators = IN_A_COMMIT

    @staticmethod
    def fault(image, cluster):
        """How the DMA ends a command."""
        code = Fault.POINTER if image // 64 % (CLUSTERS + 2) == cluster else Fault.NONE
        return {"code": code.value, "address": image + cluster + 8}

    @responder("o_command", "i_done", after=(0, 9))
    def done(self, command):
        """The DMA."""
        return [self.fault(command["image"], command["cluster"])]

    def vectors(self, config):
        return self.drawn(config, 0)

    def drawn(self, config, seed):
        draw, loads, commands, overs = random.Random(seed), [], [], []
        for number in range(14):
            image = 64 * draw.getrandbits(config.memory.address_bits - 8)
            wrong = draw.choice((1, 32, 1 << config.memory.address_bits, 1 << 63)) if number % 7 == 3 else 0
            regions, copies = draw.choice((ALL, ALL & ~OWN, OWN, draw.getrandbits(len(REGIONS)))), draw.randrange(2)
            loads.append({"image": image + wrong, "regions": regions, "copies": copies})
            steps = [(0, regions if copies else regions & ~OWN)]
            if regions & OWN and not copies:
                steps += [(cluster, regions & OWN) for cluster in range(CLUSTERS)]
            over = {"code": Fault.IMAGE.value, "address": (image + wrong) % (1 << config.memory.address_bits)}
            for cluster, some in steps if not wrong else ():
                commands.append({"image": image, "cluster": cluster, "regions": some})
                over = self.fault(image, cluster)
                if over["code"]:
                    break
            # The address has a meaning if there is a fault.
            overs.append(over if over["code"] else {**over, "address": None})
        return Vectors(inputs={"i": loads}, expected={"o_command": commands, "o_over": overs}, ports={"stored": 1})

    def known_cases(self):
        return {"drawn": Case(self.vectors, timed=False)}

    def predict(self, given, trace, component, config):
        """The DMA decides when a command ends; `test_latency` has the first command."""
        return {}


def run(dut, bench):
    async def testbench(ctx):
        await bench(ctx)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(testbench)
    simulator.run()


def load(regions, faults=(), *, image=64, copies=0, seed=1):
    """Commands, words by (cluster, is_all, record), and how it ended; DMA and clusters take their time."""
    dut, draw = LoadControl(config=CONFIG), random.Random(seed)
    commands, words, overs = [], [], []

    async def bench(ctx):
        state, left, record, pending, stored = "idle", 0, 0, 0, 0
        ctx.set(dut.i.payload, {"image": image, "regions": regions, "copies": copies})
        ctx.set(dut.i.valid, 1)
        for cycle in range(4000):
            ctx.set(dut.o_command.ready, state == "idle" and draw.random() < 0.5)
            ctx.set(dut.i_word.valid, state == "words" and draw.random() < 0.7)
            ctx.set(dut.i_word.payload, {"region": RegionNumber.CELLS, "record": record, "word": 0, "data": 5})
            ctx.set(dut.i_done.valid, state == "done")
            ctx.set(dut.i_done.payload.code, dict(faults).get(len(commands) - 1, Fault.NONE))
            ctx.set(dut.o_word.ready, draw.random() < 0.6)
            pending = max(0, pending - 1)
            ctx.set(dut.stored, pending == 0)
            stored = 0 if pending or state != "idle" else stored + 1
            if ctx.get(dut.o_command.valid) and ctx.get(dut.o_command.ready):
                command = dut.o_command.payload
                commands.append((ctx.get(command.image), ctx.get(command.cluster), ctx.get(command.regions)))
                state, left = "words", 4
            elif state == "words" and ctx.get(dut.i_word.valid) and ctx.get(dut.i_word.ready):
                out = dut.o_word.payload
                words.append((ctx.get(out.cluster), ctx.get(out.is_all), ctx.get(out.item.record)))
                record, left, pending = record + 1, left - 1, 1 + draw.randrange(30)
                state = "words" if left else "done"
            elif state == "done" and ctx.get(dut.i_done.ready):
                state = "idle"
            if ctx.get(dut.o_over.valid):
                assert not pending, "a load ends when all words are stored"
                assert stored <= 3, "and waits for nothing else"
                overs.append(Fault(ctx.get(dut.o_over.payload.code)))
            taken = ctx.get(dut.i.ready)
            await ctx.tick()
            if taken and cycle == 0:
                ctx.set(dut.i.valid, 0)
                # The host may write other numbers from now on.
                ctx.set(dut.i.payload, {"image": 1, "regions": ~regions & ALL, "copies": 1 - copies})
            if overs:
                await ctx.tick()
                assert not ctx.get(dut.busy)
                break

    run(dut, bench)
    return commands, words, overs


def test_shared_tables_come_before_each_clusters_own():
    commands, words, overs = load(ALL)
    assert commands == [(64, 0, ALL & ~OWN), *((64, k, ALL & OWN) for k in range(CLUSTERS))]
    assert words == [(0 if k < 4 else k // 4 - 1, int(k < 4), k) for k in range(4 * (CLUSTERS + 1))]
    assert overs == [Fault.NONE]


def test_copies_are_read_once_for_all_clusters():
    commands, words, overs = load(ALL, copies=1)
    assert commands == [(64, 0, ALL)]
    assert words == [(0, 1, k) for k in range(4)]
    assert overs == [Fault.NONE]


@pytest.mark.parametrize("copies", [0, 1])
def test_without_regions_of_its_own_no_cluster_is_loaded_alone(copies):
    commands, words, overs = load(ALL & ~OWN, copies=copies, seed=2)
    assert (commands, overs) == ([(64, 0, ALL & ~OWN)], [Fault.NONE])
    assert {is_all for _, is_all, _ in words} == {1}


def test_latency():
    dut, found = LoadControl(config=CONFIG), []

    async def bench(ctx):
        ctx.set(dut.i.payload, {"image": 64, "regions": ALL, "copies": 0})
        ctx.set(dut.i.valid, 1)
        for cycle in range(5):
            if ctx.get(dut.o_command.valid):
                found.append(cycle)
            await ctx.tick()

    run(dut, bench)
    assert found[0] == documented_latency(LoadControl, CONFIG) == LoadControl.latency
