"""Records of cell traversal: the hits are those of brute force, and the stages can be played again from the codes."""

from collections import Counter

import numpy as np
import pytest

from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import PRESETS
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.schedule.phase import schedule
from golden.engine.stimulus.ctu.records import CELLS, RATIO, SCENES, traversal_record

CONFIG = PRESETS["tiny"].replace({"ctu.subshell_bits": 10})


@pytest.mark.parametrize(("scene", "clusters", "kind"), [
    *(pytest.param(scene, 1 + 3 * (number % 2), {}, marks=[pytest.mark.nightly] * (number > 0))
      for number, scene in enumerate(SCENES)),
    *(pytest.param(scene, 4 - 3 * (number % 2), {"pixels": (32, 24)}, marks=[pytest.mark.nightly] * (number < 1))
      for number, scene in enumerate(SCENES[:2])),
    ("cornell", 8, {"rays": (32, 16)})])
def test_stages_follow_from_their_codes_and_the_hits_are_exact(scene, clusters, kind):
    for cell in CELLS[clusters == 1::2]:
        made = traversal_record(scene, cell=cell, config=CONFIG, clusters=clusters, **kind)
        assert len(made.hits.differences(NaiveFixed(made.shelling.geometry, CONFIG).cast(made.record))) == 0
        cast = np.zeros((made.record.rows, made.record.columns), dtype=int)
        for part in made.sectors:
            sector = part.sector
            own = cast[sector.first_row:sector.end_row, sector.first_column:sector.end_column]
            own += 1
            assert all(played.codes.shape == own.shape for played in part.played)
        assert (cast == 1).all()
        assert len(made.sectors) == clusters
        for part in made.sectors:
            unit = CellTraversalUnit(made.record, made.shelling.table, part.sector)
            for played in part.played:
                stage, pyramid = played.stage, SettlePyramid(played.codes, CONFIG)
                cells = unit.open(stage.shell, pyramid, stage.window, subshell=stage.subshell,
                                  threshold=played.threshold)
                assert Counter(cells.tolist()) == Counter(stage.cells.tolist())
            shells = [played.stage.shell for played in part.played]
            assert shells[0] == 1
            assert len({(played.stage.subshell, shell) for played, shell in zip(part.played, shells, strict=True)}) \
                == len(shells)


def test_there_are_subshells_and_rays_that_settle():
    made = traversal_record("room1627", cell=0.0625, config=CONFIG)
    (part,) = made.sectors
    assert part.played[-1].stage.subshell == len(part.subshells)
    assert len({played.stage.subshell for played in part.played}) > 5
    assert any(played.stage.grid_rays < played.stage.scanned for played in part.played)
    assert np.diff([played.codes.sum() for played in part.played]).min() >= 0


def test_each_cluster_has_its_own_section_with_its_own_subshells():
    made = traversal_record("cornell", cell=0.25, config=CONFIG, clusters=8, pixels=(32, 24))
    plan = schedule(made.record, made.shelling.geometry, made.shelling.table, CONFIG, clusters=8, ratio=RATIO)
    lists = [part.subshells for part in made.sectors]
    assert [part.sector for part in made.sectors] == list(plan.partition.sections)
    for name in "patches", "shell":
        assert [getattr(one, name).tolist() for one in lists] == [getattr(one, name).tolist() for one in plan.subshells]
    assert len({tuple(one.patches.tolist()) for one in lists}) > 4
