import random

import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator

from golden.engine.config import PRESETS
from hw.control.frustum_slot import FrustumSlot
from hw.control.job_formats import DESCRIPTOR_WORDS, NEAR_INDEX
from hw.lib.payload import pack, unpack
from tb.control.job_descriptors import changed, descriptor, near_words, words_of
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
CELLS = 1 << 24


def items(one, cells=(), *, rays=(), void=False):
    """The words of a section; ``rays`` are words already."""
    near = near_words(changed(one, ray_count=0), CONFIG)
    cells = [*cells, *[0] * (2 * near - len(cells))]
    words = [*words_of(one), *(cells[2 * k] | cells[2 * k + 1] << 32 for k in range(near)), *rays]
    return [{"cluster": 0, "index": min(k, NEAR_INDEX), "data": word, "last": int(k == len(words) - 1),
             "void": int(void and k == len(words) - 1)} for k, word in enumerate(words)]


class Slot:
    """A slot, driven cycle by cycle.

    Members
    -------
    requests
        Cycles in which one more section was requested.
    near, rays
        Near cells and listed rays that left.
    sections
        Sections that were taken, each with the cycle in which it was offered first.
    """

    def __init__(self, config=CONFIG):
        self._dut = FrustumSlot(config=config)

    def run(self, words, *, free=lambda cycle: True, takes=lambda cycle: True, begin=3, gap=0, cycles=300):
        """Words from a cycle on, ``gap`` cycles between two."""
        dut, self.requests, self.near, self.sections, self.last = self._dut, [], [], [], []
        words, self.rays = list(words), []
        ports = [Value.cast(one) for one in (dut.requests, dut.o.valid, dut.o.payload, dut.o_near.valid,
                                             dut.o_near.payload)]
        lists = getattr(dut, "o_ray", None)

        async def drive(ctx):
            since = None
            for cycle in range(cycles):
                offers = words and cycle >= begin and (cycle - begin) % (gap + 1) == 0
                ctx.set(dut.i.valid, int(bool(offers)))
                if offers:
                    word = words.pop(0)
                    ctx.set(dut.i.payload, word)
                    self.last += [cycle] if word["last"] else []
                full = ctx.get(dut.o.valid)
                ctx.set(dut.free, int(free(cycle) and not full))
                ctx.set(dut.o.ready, int(takes(cycle)))
                if lists is not None and ctx.get(lists.valid):
                    self.rays.append(unpack(lists.payload.shape(), ctx.get(Value.cast(lists.payload))))
                requests, valid, section, near, cells = (await ctx.tick().sample(*ports))[2:]
                if requests:
                    self.requests.append(cycle)
                if near:
                    self.near.append(unpack(dut.o_near.payload.shape(), cells))
                since = (cycle if since is None else since) if valid else None
                if valid and takes(cycle):
                    self.sections.append((since, unpack(dut.o.payload.shape(), section)))

        simulator = Simulator(dut)
        simulator.add_clock(1e-8)
        simulator.add_testbench(drive)
        simulator.run()
        return self


def expected(one, bank):
    """What the units get of a descriptor."""
    shape = FrustumSlot(config=CONFIG).o.payload.shape()["numbers"].shape
    numbers = {name: one[name].reshape(3, 3).tolist() if name in ("matrix", "to_global") else one[name].tolist()
               for name, _ in shape if name != "is_screen"} | {"is_screen": int(one["bundle"])}
    numbers = unpack(shape, pack(shape, numbers))
    section = {name: int(one[name]) for name in ("first_column", "end_column", "first_row", "end_row")}
    return {"numbers": numbers, "section": section, "last_shell": int(one["last_shell"]),
            "near_cells": int(one["near_count"]), "bank": bank,
            "results": {"section": section, "columns": int(one["columns"]), **{
                name: int(one[name]) for name in ("hit_format", "sums", "hits", "sums_address")}}}


@pytest.mark.parametrize("gap", [0, 2])
def test_sections_one_after_the_other(gap):
    draw = random.Random(gap)
    ones = [descriptor(CONFIG, draw, near_count=count) for count in (5, 0, 6)]
    cells = [[draw.randrange(CELLS) for _ in range(int(one["near_count"]))] for one in ones]
    slot = Slot().run([item for one, near in zip(ones, cells, strict=True) for item in items(one, near)], gap=gap,
                      cycles=400)
    assert [section for _, section in slot.sections] == [expected(one, k % 2) for k, one in enumerate(ones)]
    assert [offered - last for (offered, _), last in zip(slot.sections, slot.last, strict=True)] == [
        documented_latency(FrustumSlot, CONFIG)] * 3
    pairs = [(bank % 2, address, near[2 * address] | [*near, 0][2 * address + 1] << 24)
             for bank, near in enumerate(cells) for address in range(-(-len(near) // 2))]
    assert [(one["bank"], one["address"], one["cells"]) for one in slot.near] == pairs


def test_listed_rays_follow_the_near_cells():
    """Of shadow frusta with and without near cells; none of a screen, whose list is empty again."""
    config, draw = CONFIG.replace({"icu.shadow_bits": 4}), random.Random(5)
    x, y, end = 17, 17, 24
    ones = [descriptor(config, draw, near_count=cells, ray_count=rays, bundle=bundle)
            for cells, rays, bundle in ((3, 16, 2), (0, 2, 2), (4, 0, 1))]
    rays = [[tuple(draw.randrange(1 << bits) for bits in (x, y, end)) for _ in range(int(one["ray_count"]))]
            for one in ones]
    slot = Slot(config).run([item for one, listed in zip(ones, rays, strict=True) for item in items(
        one, rays=[one_x | one_y << 20 | one_end << 40 for one_x, one_y, one_end in listed])], cycles=200)
    assert [(one["address"], *one["entry"].values()) for one in slot.rays] == [
        (address, *ray) for listed in rays for address, ray in enumerate(listed)]
    assert [(bank["bank"], bank["address"]) for bank in slot.near] == [(0, 0), (0, 1), (0, 0), (0, 1)]
    assert [(section["rays"], section["numbers"]["is_screen"], section["numbers"]["is_shadow"])
            for _, section in slot.sections] == [(16, 1, 1), (2, 1, 1), (0, 1, 0)]


def test_a_section_waits_until_it_is_taken_and_stays():
    one = descriptor(CONFIG, random.Random(1))
    slot = Slot().run(items(one), takes=lambda cycle: cycle == 200)
    ((offered, section),) = slot.sections
    assert (offered, section) == (slot.last[0] + FrustumSlot.latency, expected(one, 0))


def test_one_want_for_each_section():
    """When it is empty and the cluster is free; once, whatever time the words take."""
    one = descriptor(CONFIG, random.Random(2))
    slot = Slot().run(items(one), free=lambda cycle: cycle > 20, begin=60, takes=lambda cycle: cycle == 150)
    assert slot.requests == [21, 151]
    assert Slot().run([], free=lambda cycle: False).requests == []


def test_a_void_section_leaves_it_empty():
    """The next one comes without another want, into the same bank."""
    draw = random.Random(3)
    ones = [descriptor(CONFIG, draw, near_count=4) for _ in range(2)]
    slot = Slot().run([*items(ones[0], [1, 2, 3, 4], void=True), *items(ones[1], [5, 6, 7, 8])],
                      takes=lambda cycle: cycle == 200, cycles=202)
    assert slot.sections == [(slot.last[1] + FrustumSlot.latency, expected(ones[1], 0))]
    assert len(slot.requests) == 2
    assert [(one["bank"], one["address"]) for one in slot.near] == [(0, 0), (0, 1)] * 2


def test_cells_beyond_the_scene_are_no_cells():
    one = descriptor(CONFIG, random.Random(4), near_count=4)
    slot = Slot().run(items(one, [CELLS, CELLS - 1, 5 + (1 << 31), 7]))
    assert [cell["cells"] for cell in slot.near] == [CELLS - 1 | CELLS - 1 << 24, CELLS - 1 | 7 << 24]


def test_the_words_of_a_descriptor():
    assert [item["index"] for item in items(descriptor(CONFIG, random.Random(1), near_count=0))] == list(
        range(DESCRIPTOR_WORDS))
