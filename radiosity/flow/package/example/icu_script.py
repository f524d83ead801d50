"""The example of an intersection unit: a hemisphere and a screen in the Cornell box, with their sums."""

import numpy as np

from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.frustum_choice import FrustumChoice
from golden.engine.icu.patch_sums import section_sums
from golden.engine.icu.settle_code import settle_code
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.open import open_scene
from hw.icu.intersection_unit import IntersectionUnit
from radiosity.flow.package.example.fitting_image import fitting_image
from radiosity.flow.package.example.frustum_load import frustum_payload, table_writes
from radiosity.flow.package.example.settle_words import settle_words
from radiosity.flow.package.example.stream_script import Script

__all__ = ["icu_script", "vertices"]

_SCENE, _CELL, _FRUSTA = "cornell", 0.5, ({"patch": 4, "rays": (32, 8)}, {"screen": (24, 16)})


def vertices(geometry: PatchGeometry, patches: np.ndarray) -> list[dict]:
    """The vertices of some patches one after the other: values of `Formats.patch_vertex`."""
    return [{"patch": patch, "surface": int(geometry.surface[patch]), "vertex": vertex}
            for patch in patches.tolist() for vertex in geometry.vertices[patch].tolist()]


def icu_script(unit: IntersectionUnit, config: Config) -> Script:
    """Tables, frustum, patches in an order at random; then the settle map, the hits and the sums.

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
    for number, choice in enumerate(_FRUSTA):
        record, geometry, weights = FrustumChoice(**choice).record(scene, config)
        fitting_image(record, geometry, job_shelling(geometry, config, cell=_CELL).table, config)
        weights = np.arange(1, record.rows + 1) if weights is None else weights
        script.hold("patches", len(geometry))
        order = np.random.default_rng(number).permutation(len(geometry))
        script.give("i_table", table_writes(record, config, weights))
        script.next_step()
        script.give("i_frustum", [frustum_payload(record, Sector.whole(record), config)])
        script.next_step()
        script.give("i_vertex", vertices(geometry, order))
        script.require("o_done", order.tolist())
        script.next_step()
        _require_results(script, record, geometry, weights, config)
        script.next_step()
    return script


def _require_results(script, record: FrustumRecord, geometry, weights, config):
    hits = NaiveFixed(geometry, config).cast(record)
    words = settle_words(settle_code(hits.inverse.reshape(record.rows, record.columns), config), config)
    script.give("i_settle", range(len(words)))
    script.require("o_settle", words)
    script.next_step()
    script.give("i_read_out", [None])
    rays = np.arange(len(record))
    script.require("o_hit", [
        {"column": ray % record.columns, "row": ray // record.columns, "last": ray == rays[-1],
         "hit": {"inverse": inverse, "patch": max(patch, 0), "u": u, "v": v}}
        for ray, inverse, patch, u, v in zip(rays.tolist(), *(
            getattr(hits, name).tolist() for name in ("inverse", "patch", "u", "v")), strict=True)])
    sums = section_sums(hits.patch, weights[rays // record.columns])
    script.require("o_sum", [
        {"patch": patch, "sum": total, "overflow": 0, "is_sum": 1, "last": number == len(sums.patch) - 1}
        for number, (patch, total) in enumerate(zip(sums.patch.tolist(), sums.sum.tolist(), strict=True))])
