"""A string agrees with the counts: every cell and patch once per frustum and cluster."""

import numpy as np

from benchmarks.viewpoints import hard_records
from golden.engine.cast.shelling import Shelling
from golden.engine.ctu.sector import Sector
from golden.engine.memsys.bus.reference_strings import ReferenceStrings
from golden.scene.open import open_scene
from tb.golden.cast.frusta import CONFIG


def test_strings_hold_what_the_counts_count():
    geometry, records = hard_records(open_scene("cornell"), origins=2, rays=(64, 16), pixels=(32, 32), seed=3)
    records = [record for record in records if record.rows == 16]
    half = records[0].columns // 2
    sectors = (Sector(0, half, 0, 16), Sector(half, 2 * half, 0, 16))
    shelling = Shelling(geometry, CONFIG, cell=0.125)
    strings = ReferenceStrings.of(shelling, records, sectors)
    assert len(strings.cells) == len(strings.patches) == len(records) > 1
    for record, cells, patches in zip(records, strings.cells, strings.patches, strict=True):
        counts = shelling.cast(record, sectors)[1]
        assert [len(string) for string in cells] == [cluster.cells for cluster in counts]
        assert [len(string) for string in patches] == [cluster.patches for cluster in counts]
        for opened, found in zip(cells, patches, strict=True):
            assert len(np.unique(opened)) == len(opened)
            assert len(found)
            assert set(found) == set(shelling.table.patches.read(shelling.table.entries(opened)))
