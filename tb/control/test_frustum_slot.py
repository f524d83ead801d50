from amaranth.hdl import Shape

from golden.engine.frustum.ray_list import END_BIT, X_BIT, Y_BIT
from golden.engine.jobs.result_formats import HitFormat, bit_words
from hw.control.frustum_slot import CELL_BITS, FrustumSlot
from hw.control.job_formats import NEAR_INDEX, Bundle, JobFormats
from hw.ctu.ctu_formats import CtuFormats
from hw.icu.icu_formats import IcuFormats
from hw.lib.payload import pack, unpack
from tb.control.job_descriptors import descriptor, words_of
from tb.lib.bench import Bench

BOUNDS = ("first_column", "end_column", "first_row", "end_row")


class TestFrustumSlot(Bench):
    component, span = FrustumSlot, 300
    changes, variants = {"icu.shadow_bits": 7}, ({},)

    def model(self, config):
        """A section is there two cycles after its last word, near cells and a ray are one cycle after theirs."""
        self.present, self.section, self.is_requested = config, None, False
        waits, bank, number, word, one = False, 0, 0, None, None
        given = yield
        while True:
            requests = given.free and self.section is None and not waits
            outputs = {"requests": int(requests), "o": self.section, "o_near": None, "o_ray": None}
            if word is not None and word["index"] == NEAR_INDEX:
                near = -(-int(one["near_count"]) // 2)
                if number < near:
                    outputs["o_near"] = {"bank": bank, "address": number, "cells": cells_of(word["data"], config)}
                else:
                    outputs["o_ray"] = {"address": number - near, "entry": ray_of(word["data"], config)}
                number += 1
            waits, self.is_requested = waits or requests, self.is_requested or requests
            if self.section is not None and given.o:
                self.section, waits, bank = None, False, 1 - bank
            if word is not None and word["last"]:
                number = 0
                if not word["void"]:
                    self.section = section_of(one, bank, config)
            word = given.i
            if word is not None and word["index"] == 0:
                one = self.one
            given = yield outputs

    def items(self, name, shape, random):
        """The words of a section for each request; behind a void one the next one follows without another request."""
        others, scene = super().items(name, shape, random), 1 << CtuFormats(self.present).cell.width
        while True:
            while not self.is_requested:
                yield None
            is_shadow = self.present.icu.shadow_bits and random.random() < 0.7
            rays = random.choice((0, 1, 9, 64, 65)) if is_shadow else 0
            bounds = {name: random.randrange(1 << self.present.icu.side_bits) for name in BOUNDS}
            self.one = descriptor(self.present, random, ray_count=rays, **bounds, **(
                {"bundle": Bundle.SHADOW.value, "hit_format": 0, "sums": 0} if is_shadow else {}))
            pairs = [random.choices((random.randrange(scene), scene - 1, scene, (1 << CELL_BITS) - 1), k=2)
                     for _ in range(-(-int(self.one["near_count"]) // 2))]
            words = [*words_of(self.one), *(low | high << CELL_BITS for low, high in pairs),
                     *(random.getrandbits(64) for _ in range(rays))]
            void = int(random.random() < 0.3)
            for number, data in enumerate(words):
                last = number == len(words) - 1
                self.is_requested &= not last or bool(void)
                yield next(others) | {"index": min(number, NEAR_INDEX), "data": data, "last": int(last),
                                      "void": int(last and void)}

    def drive(self, given, random):
        """The cluster has no use for another section while one waits."""
        given.free &= self.section is None


class TestSlotWithoutLists(TestFrustumSlot):
    changes = {"icu.shadow_bits": 0}
    test_in_the_simulator = None


def cells_of(data, config):
    """Two near cells; a number beyond the scene's becomes the highest one."""
    width = CtuFormats(config).cell.width
    low, high = (min(data >> first & (1 << CELL_BITS) - 1, (1 << width) - 1) for first in (0, CELL_BITS))
    return low | high << width


def ray_of(data, config):
    """The fields of a listed ray."""
    entry = IcuFormats(config).ray_entry
    return {name: data >> first & (1 << Shape.cast(entry[name].shape).width) - 1
            for name, first in (("x", X_BIT), ("y", Y_BIT), ("end", END_BIT))}


def section_of(one, bank, config):
    """What the units get of a descriptor."""
    numbers = JobFormats(config).slot["numbers"].shape
    kinds = {"is_screen": int(one["bundle"] != Bundle.HEMISPHERE), "is_shadow": int(one["bundle"] == Bundle.SHADOW)}
    rays = int(one["ray_count"])
    section = {name: int(one[name]) for name in BOUNDS}
    # Of the descriptor's bits those that the machine's numbers have.
    given = unpack(numbers, pack(numbers, {name: kinds[name] if name in kinds else one[name].reshape(
        (3, 3) if name in ("matrix", "to_global") else one[name].shape).tolist() for name, _ in numbers}))
    results = {"section": section, "columns": int(one["columns"]), **{
        name: int(one[name]) for name in ("hit_format", "sums", "hits", "sums_address")}}
    if kinds["is_shadow"]:
        # The words of its list.
        results |= {"hit_format": HitFormat.COMPACT, "section": {
            "first_column": 0, "end_column": bit_words(rays), "first_row": 0, "end_row": 1}}
    return {"numbers": given, "section": section, "last_shell": int(one["last_shell"]),
            "near_cells": int(one["near_count"]), "bank": bank, "results": results,
            **({"rays": rays} if config.icu.shadow_bits else {})}
