import numpy as np
from amaranth.sim import Simulator

from golden.config import PRESETS
from golden.memory_map import BEATS, REGIONS, pack_beats
from hw.memsys.image_layout import RegionNumber
from hw.memsys.table_load import TableLoad
from tb.lib.payload import unpack
from tb.lib.timing import documented_latency
from tb.memsys.patch_words import load_of

CONFIG = PRESETS["tiny"]


def test_words_of_records_go_to_their_tables():
    """Records as golden's layout has them; words of other regions go nowhere, and none without valid."""
    random, dtype = np.random.default_rng(1), {region.name: region.dtype for region in REGIONS}
    records = {name: np.zeros(3, dtype[name]) for name in ("cells", "patch_lists", "residence", "patches", "shells")}
    records["cells"]["pointer"], records["cells"]["count"] = [5, 1 << 31, 7], [9, 0, 3]
    records["patch_lists"]["patch"] = [4, 8, 1 << 20]
    records["residence"]["cluster"], records["residence"]["address"] = [-1, 1, 0], [-1, 9, 0]
    vertices = random.integers(1 << 24, size=(3, 4, 3))
    low, high = pack_beats(vertices)
    records["patches"]["id"], records["patches"]["surface"] = [6, 2, 9], [-1, 3, 4]
    records["patches"]["vertex"], records["patches"]["top"][:, 1:BEATS] = low, high
    none = (1 << 32) - 1
    expected = {
        "cells": [{"address": k, "record": {"pointer": a, "count": b}} for k, (a, b) in enumerate(
            [(5, 9), (1 << 31, 0), (7, 3)])],
        "patch_lists": [{"address": k, "record": patch} for k, patch in enumerate([4, 8, 1 << 20])],
        "residence": [{"address": k, "record": {"cluster": a, "address": b}} for k, (a, b) in enumerate(
            [(none, none), (1, 9), (0, 0)])],
        "patches": [load for k in range(3) for load in load_of(
            k, int(records["patches"]["id"][k]), int(records["patches"]["surface"][k]), vertices[k])]}
    dut = TableLoad(config=CONFIG)
    outs = dict(zip(expected, (dut.o_cells, dut.o_lists, dut.o_types, dut.o_geometry), strict=True))
    came = {name: [] for name in expected}

    async def drive(ctx):
        for name, array in records.items():
            size = 4 if array.dtype.itemsize == 4 else 8
            words = np.frombuffer(array.tobytes(), dtype=f"<u{size}").reshape(len(array), -1)[:, :6]
            for record, row in enumerate(words):
                for word, value in enumerate(row):
                    ctx.set(dut.i.payload, {"region": RegionNumber[name.upper()], "record": record, "word": word,
                                            "data": int(value)})
                    for is_valid in range(2):
                        ctx.set(dut.i.valid, is_valid)
                        await ctx.tick().repeat(dut.latency)
                        valid = {which for which, out in outs.items() if ctx.get(out.valid)}
                        assert valid == ({name} & set(outs) if is_valid else set())
                        for which in valid:
                            payload = outs[which].payload
                            came[which].append(unpack(payload.shape(), ctx.get(payload.as_value())))

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(drive)
    simulator.run()
    assert came == expected
    assert dut.latency == documented_latency(TableLoad, CONFIG)
