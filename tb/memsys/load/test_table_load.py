import numpy as np

from golden.engine.memory_map import BEATS, REGIONS, pack_beats
from hw.memsys.load.image_layout import PATCH_WORDS, RegionNumber
from hw.memsys.load.table_load import TableLoad
from tb.lib.bench import Bench, Vectors
from tb.memsys.patch_words import load_of

# By region of the image the output for its words.
OUTPUTS = {"cells": "o_cells", "patch_lists": "o_lists", "residence": "o_types", "patches": "o_geometry"}
NONE, COUNT = (1 << 32) - 1, 12


class TestTableLoad(Bench):
    """Records as golden's layout has them; words of other regions go nowhere."""

    component, variants, splits = TableLoad, ({},), False

    def vectors(self, config):
        return self.drawn(config, 1)

    def drawn(self, config, seed):
        random, dtype = np.random.default_rng(seed), {region.name: region.dtype for region in REGIONS}
        records = {name: np.zeros(COUNT, dtype[name]) for name in (*OUTPUTS, "shells")}
        pointer, count, patch, cluster, address, ids, surface = random.choice(
            (0, 1, 9, 1 << 31, NONE), size=(7, COUNT)).tolist()
        vertices = random.integers(1 << 24, size=(COUNT, 4, 3))
        for region, fields in {
                "cells": {"pointer": pointer, "count": count}, "patch_lists": {"patch": patch},
                "residence": {"cluster": cluster, "address": address},
                "patches": {"id": ids, "surface": surface}}.items():
            for name, values in fields.items():
                records[region][name] = np.array(values, dtype="<u4").view(records[region][name].dtype)
        records["patches"]["vertex"], records["patches"]["top"][:, 1:BEATS] = pack_beats(vertices)
        expected = {
            "o_cells": [{"pointer": a, "count": b} for a, b in zip(pointer, count, strict=True)], "o_lists": patch,
            "o_types": [{"cluster": a, "address": b} for a, b in zip(cluster, address, strict=True)]}
        expected = {name: [{"address": k, "record": record} for k, record in enumerate(those)]
                    for name, those in expected.items()}
        expected["o_geometry"] = [load for k in range(COUNT) for load in load_of(k, ids[k], surface[k], vertices[k])]
        return Vectors(inputs={"i": [word for name, array in records.items() for word in words(name, array)]},
                       expected=expected)

    def predict(self, given, trace, component, config):
        cycles = {name: [] for name in given.expected}
        for item, cycle in zip(given.inputs["i"], trace.offered["i"], strict=True):
            if output := OUTPUTS.get(RegionNumber(item["region"]).name.lower()):
                cycles[output].append(cycle + component.latency)
        return {"i": trace.offered["i"], **cycles}


def words(name, array):
    """The words of the records of a region."""
    size = 4 if array.dtype.itemsize == 4 else 8
    rows = np.frombuffer(array.tobytes(), dtype=f"<u{size}").reshape(len(array), -1)[:, :PATCH_WORDS]
    return [{"region": RegionNumber[name.upper()].value, "record": record, "word": number, "data": int(data)}
            for record, row in enumerate(rows) for number, data in enumerate(row)]
