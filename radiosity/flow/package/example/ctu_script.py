"""The example of a traversal unit: the cells of a hemisphere in the Cornell box, most of whose rays are settled."""

from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum.frustum_choice import FrustumChoice
from golden.engine.icu.settle_code import settle_code
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.open import open_scene
from hw.ctu.stage_count import NEAR_STAGE
from hw.ctu.traversal_unit import TraversalUnit
from radiosity.flow.package.example.fitting_image import fitting_image
from radiosity.flow.package.example.frustum_load import frustum_payload
from radiosity.flow.package.example.grid_load import unit_writes
from radiosity.flow.package.example.settle_words import settle_words
from radiosity.flow.package.example.stream_script import Script

__all__ = ["ctu_script"]

_SCENE, _FRUSTUM, _CELL = "cornell", {"patch": 4, "rays": (32, 8)}, 0.2
# Cycles in which the survival test reads the whole settle map twice, for each tile of it.
_SWEEP = 8
# Stages are numbered modulo this.
_STAGES = NEAR_STAGE + 1


def ctu_script(unit: TraversalUnit, config: Config) -> Script:
    """Tables and frustum, and when the settle map has been read the near cells; then all cells.

    The settle map is that of the frustum's hits from the beginning on. So which grid rays survive does not depend on
    cycles, and the cells are golden's, stage by stage. Within a stage they come in any order: rays are traversed
    beside each other.

    Parameters
    ----------
    unit, config
        The unit, and its configuration.

    Raises
    ------
    InputError
        See `fitting_image`.
    """
    script, scene = Script(unit), open_scene(_SCENE)
    record, geometry, _ = FrustumChoice(**_FRUSTUM).record(scene, config)
    table, sector = job_shelling(geometry, config, cell=_CELL).table, Sector.whole(record)
    fitting_image(record, geometry, table, config)
    codes = settle_code(NaiveFixed(geometry, config).cast(record).inverse.reshape(record.rows, record.columns), config)
    golden = CellTraversalUnit(record, table, sector)
    near, words = golden.open(1, None).tolist(), settle_words(codes, config)
    script.hold("settled", 1)
    script.answer("o_tile", "i_word", {tile: [word] for tile, word in enumerate(words)})
    script.give("i_table", unit_writes(golden, config))
    script.next_step()
    frustum = frustum_payload(record, sector, config)
    script.give("i_frustum", [{
        "traversal": {"frustum": frustum, "to_global": record.to_global.tolist(),
                      "grid_origin": table.position(record.origin).tolist(), "cells": table.shape.tolist()},
        "last_shell": golden.last_shell,
        "subshells": {"first": 0, "count": 0, "patches": len(geometry)}}])
    script.next_step(pause=_SWEEP * len(words))
    script.give("i_near", [{"cell": cell, "is_cell": 1, "last": k == len(near) - 1} for k, cell in enumerate(near)]
                or [{"last": 1}])
    stages = [(NEAR_STAGE, near)]
    for shell in range(2, golden.last_shell + 1):
        opened = golden.open(shell, SettlePyramid(codes, config), threshold=golden.threshold(shell, config))
        stages.append(((shell - 2) % _STAGES, opened.tolist()))
    for stage, cells in stages:
        script.require("o", [{"stage": stage, "cell": cell, "final": 0} for cell in cells], any_order=True)
        script.next_step()
    script.require("o", [{"stage": None, "cell": None, "final": 1}])
    return script
