"""The tables of a cluster, against golden's scene: cells, lists, residence, geometry."""

import random
from itertools import repeat

from golden.engine.config import PRESETS
from hw.memsys.patches.cell_table import CellTable
from hw.memsys.patches.local_patch_geometry import LocalPatchGeometry
from hw.memsys.patches.patch_table import PatchTable
from hw.memsys.patches.patch_type_memory import PatchTypeMemory
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Expand, Rigid, passage
from tb.memsys.patch_words import load_of

CHANGES = {"memsys.scene_cells": 64, "memsys.own_cells": 32, "memsys.own_entries": 64, "memsys.own_patches": 16,
           "icu.patch_bits": 8, "noc.columns": 3, "noc.rows": 1}
CONFIG = PRESETS["tiny"].replace(CHANGES)
NONE = (1 << 32) - 1
EVERY_CLUSTER = NONE - 1


class Table(Bench):
    """A table is loaded once; requests come at one side or at two."""

    changes, variants, splits, cycles = CHANGES, ({},), False, 100_000
    sides = ("",)

    def stages(self, component, config):
        """Of one side."""
        return [Rigid(component.latency)]

    def predict(self, given, trace, component, config):
        """Sides do not stall each other."""
        found = {}
        for side in self.sides:
            found[f"i{side}"], found[f"o{side}"] = passage(
                self.stages(component, config), trace.offered[f"i{side}"], trace.stalled[f"o{side}"])
        return found


def cells(draw):
    """Records of 40 cells, all kinds among them: lists here, beyond, empty, and such that cannot be."""
    lists = 90
    records = [(0, 64), (0, 65), (63, 1), (64, 1), (5, 0), (80, 0), (0, lists), (0, lists + 1), (lists, 1),
               (NONE, 1), (NONE, NONE), (1, NONE)]
    records += [(draw.randrange(60), draw.randrange(5)) for _ in range(40 - len(records))]
    return lists, records


def found_cell(number, record, lists):
    """What the table says of a cell."""
    pointer, count = record
    if number >= CONFIG.memsys.own_cells:
        return {"cell": number, "list": {"pointer": None, "count": None}, "is_own": 0, "is_empty": 0, "wrong": 0}
    end = pointer + count
    return {"cell": number, "list": {"pointer": pointer, "count": count}, "is_own": end <= CONFIG.memsys.own_entries,
            "is_empty": count == 0, "wrong": end > lists}


class TestCellTable(Table):
    component = CellTable

    def vectors(self, config):
        """What the block RAM holds in the row of a cell that has no record here does not matter."""
        draw = random.Random(1)
        lists, records = cells(draw)
        requests = [draw.randrange(len(records)) for _ in range(60)] + list(range(len(records)))
        return Vectors(inputs={"i": requests}, ports={"lists": lists},
                       expected={"o": [found_cell(number, records[number], lists) for number in requests]},
                       first={"i_load": [{"address": number, "record": {"pointer": pointer, "count": count}}
                                         for number, (pointer, count) in enumerate(records)]})


class TestPatchTable(Table):
    component = PatchTable

    def stages(self, component, config):
        counts = (given["count"] for given in self.now.inputs["i"])
        return [Rigid(1), Expand(counts, holds=True), Rigid(component.latency - 1)]

    def vectors(self, config):
        draw, patches = random.Random(2), 50
        entries = [draw.choice([draw.randrange(patches), patches, patches + 20, NONE]) for _ in range(64)]
        lists = [(0, 64), (63, 1), (0, 1), (1, 1), (2, 2)]
        lists += [(pointer, draw.randrange(1, 65 - pointer)) for pointer in [draw.randrange(64) for _ in range(6)]]
        return Vectors(
            inputs={"i": [{"pointer": pointer, "count": count} for pointer, count in lists]},
            expected={"o": [{"number": entries[k] if entries[k] < patches else 1 << config.icu.patch_bits,
                             "last": k == pointer + count - 1}
                            for pointer, count in lists for k in range(pointer, pointer + count)]},
            first={"i_load": [{"address": address, "record": entry} for address, entry in enumerate([*entries, 7, 8])]},
            ports={"patches": patches})


class TestPatchTypeMemory(Table):
    component, sides = PatchTypeMemory, ("", "_remote")

    def vectors(self, config):
        draw, own_number = random.Random(3), 2
        residence = [(NONE, NONE), (0, 0), (2, 15), (3, 0), (NONE - 2, 3), (EVERY_CLUSTER, 7), (EVERY_CLUSTER, 16),
                     (1, 16), (1, NONE), (0, 1 << 20)]
        residence += [draw.choice([(NONE, NONE), (draw.randrange(3), draw.randrange(16))]) for _ in range(56)]

        def found(patch):
            cluster, address = residence[patch]
            cluster = own_number if cluster == EVERY_CLUSTER else cluster
            known, fits = cluster < 3, address < config.memsys.own_patches
            return {"patch": patch, "is_held": known and fits, "cluster": cluster, "address": address,
                    "wrong": cluster != NONE and (not known or address >> 31)}

        own, others = ([draw.randrange(8 if k < 20 else 64) for k in range(70)] for _ in range(2))
        requests = [{"node": draw.randrange(3), "patch": patch} for patch in others]
        loads = [{"address": patch, "record": {"cluster": cluster, "address": address}}
                 for patch, (cluster, address) in enumerate(residence)]
        return Vectors(
            inputs={"i": own, "i_remote": requests},
            expected={"o": [found(patch) for patch in own],
                      "o_remote": [{"node": item["node"], "found": found(item["patch"])} for item in requests]},
            first={"i_load": [*loads, {"address": 256, "record": {"cluster": 1, "address": 1}}]},
            ports={"cluster": own_number})


class TestLocalPatchGeometry(Table):
    component, sides = LocalPatchGeometry, ("", "_remote")

    def stages(self, component, config):
        return [Rigid(1), Expand(repeat(4), holds=True), Rigid(component.latency - 1)]

    def vectors(self, config):
        draw, cluster = random.Random(4), 1
        held = [(draw.randrange(64), draw.randrange(-9, 99),
                 [[draw.randrange(1 << config.numbers.scene_bits) for _ in range(3)] for _ in range(4)])
                for _ in range(16)]
        loads = [word for address, patch in enumerate(held) for word in load_of(address, *patch)]
        # What does not belong here is ignored.
        loads += load_of(16, 1, 2, [[3, 4, 5]] * 4)
        nobody = [[0, 0, 0]] * 4

        def vertices(patch, address, there=True):
            number, surface, points = held[address]
            is_there = there and number == patch
            return [{"patch": patch, "surface": surface, "vertex": point} for point in (points if is_there else nobody)]

        def request(wrong):
            address = draw.randrange(16)
            return {"patch": held[address][0] ^ (wrong and draw.random() < 0.3), "address": address}

        own = [request(k > 12) for k in range(24)]
        requests = [{"node": draw.randrange(3), "found": {
            **request(k > 6), "is_held": draw.random() < 0.9, "wrong": k == 18,
            "cluster": draw.choice([1, 1, 1, 2])}} for k in range(24)]
        answers = [{"node": item["node"], "vertex": vertex} for item in requests for vertex in vertices(
            item["found"]["patch"], item["found"]["address"],
            item["found"]["is_held"] and not item["found"]["wrong"] and item["found"]["cluster"] == cluster)]
        return Vectors(inputs={"i": own, "i_remote": requests}, first={"i_load": loads}, ports={"cluster": cluster},
                       expected={"o": [vertex for item in own for vertex in vertices(**item)], "o_remote": answers})
