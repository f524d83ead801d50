"""Requests of clusters to a patch node: the patches that it holds, in order, and a reset among them."""

import random
from itertools import repeat

from golden.engine.config import PRESETS
from golden.engine.memory_map.layout import EVERY_CLUSTER, NONE
from hw.memsys.load.image_layout import RegionNumber
from hw.memsys.patch_node import PatchNode
from hw.memsys.patches.local_patch_geometry import LocalPatchGeometry
from hw.memsys.patches.patch_type_memory import PatchTypeMemory
from tb.lib.bench import Bench, Vectors
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stages import Elastic, Expand, Rigid
from tb.memsys.patch_words import words_of

CHANGES = {"memsys.own_patches": 16, "icu.patch_bits": 8, "noc.columns": 3, "noc.rows": 1, "noc.patch_nodes": 2}
NODE, WORD = 2, 1 << 32


def word(region, record, number, data, node=None):
    """A word for all nodes, or for one."""
    return {"item": {"region": region.value, "record": record, "word": number, "data": data}, "cluster": node or 0,
            "is_all": int(node is None)}


class TestPatchNode(Bench):
    component, changes, variants, splits, cycles = PatchNode, CHANGES, ({},), False, 100_000

    def stages(self, component, config):
        """The tables, then a register of ``ready``."""
        types, geometry = PatchTypeMemory(config=config), LocalPatchGeometry(config=config)
        return [Rigid(types.latency), Rigid(1), Expand(repeat(4), holds=True), Rigid(geometry.latency - 1),
                Elastic(0, 1)]

    def vectors(self, config):
        """Patches of this node, of another one, of all and of none; one whose place has another patch."""
        draw = random.Random(5)
        held = [(patch, draw.randrange(99), [[draw.randrange(1 << config.numbers.scene_bits) for _ in range(3)]
                                             for _ in range(4)]) for patch in draw.sample(range(40), 16)]
        places = {patch: (NODE, address) for address, (patch, *_) in enumerate(held[:-2])}
        places |= {held[-1][0]: (EVERY_CLUSTER, 15), 50: (NODE, 3), 51: (1, 4), 52: (NONE, NONE)}
        loads = [word(RegionNumber.RESIDENCE, patch, 0, cluster % WORD | address % WORD << 32)
                 for patch, (cluster, address) in places.items()]
        loads += [word(RegionNumber.PATCHES, address, number, data, NODE)
                  for address, patch in enumerate(held) for number, data in enumerate(words_of(*patch))]
        # Of the other nodes, and of a region that only clusters have.
        loads += [word(RegionNumber.PATCHES, 0, 2, 1, node) for node in (0, 1)] + [word(RegionNumber.CELLS, 0, 0, 1)]
        here = {patch: points for patch, _, points in held[:-2] + held[-1:]}
        surfaces = {address: surface for address, (_, surface, _) in enumerate(held)}
        requests = [{"node": draw.randrange(2), "patch": patch} for patch in [*places, *draw.choices([*places], k=30)]]
        answers = [{"node": item["node"], "vertex": {
            "patch": item["patch"], "surface": surfaces[places[item["patch"]][1] % 16], "vertex": point}}
            for item in requests for point in here.get(item["patch"], [[0, 0, 0]] * 4)]
        return Vectors(inputs={"i_remote": requests}, first={"i_word": loads}, ports={"number": NODE},
                       expected={"o_remote": answers})


def test_a_reset_ends_a_reply_and_keeps_the_tables():
    """Vertices that were left would come before those of the next patch. One leaves in the cycle of the reset."""
    patches = [(patch, 0, [[patch, 1, number] for number in range(4)]) for patch in (7, 9)]
    loads = [word(RegionNumber.RESIDENCE, patch, 0, NODE | address << 32)
             for address, (patch, *_) in enumerate(patches)]
    loads += [word(RegionNumber.PATCHES, address, number, data, NODE)
              for address, patch in enumerate(patches) for number, data in enumerate(words_of(*patch))]
    requests = [(8, {"node": 0, "patch": 7}), (12, {"node": 1, "patch": 9})]
    bench = ScheduleBench(PatchNode(config=PRESETS["tiny"].replace(CHANGES)))
    came = bench.run(Schedule(items={"i_remote": requests}, first={"i_word": loads}), number=NODE,
                     reset=lambda cycles: int(len(cycles["o_remote"]) == 1))
    first, second = ([{"node": node, "vertex": {"patch": patch, "surface": 0, "vertex": point}} for point in points]
                     for node, (patch, _, points) in enumerate(patches))
    assert came["o_remote"] == [*first[:2], *second]
