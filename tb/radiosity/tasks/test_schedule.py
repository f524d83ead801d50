"""Each figure of the report of a schedule is that of its own casting and cluster."""

import numpy as np
import pytest
from PIL import Image

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.frustum import hemisphere_record
from golden.engine.memory_map import from_bytes
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.phase import schedule
from golden.light.image import label_colours
from golden.scene.open import open_scene
from radiosity.tasks.schedule import schedule_phase

CONFIG, RAYS, CELL = PRESETS["paper"], (32, 8), 0.25
OPTIONS = {"clusters": 4, "ratio": 4, "capacity": 6, "topology": "ring"}


def test_figures_image_and_picture(tmp_path):
    report, text = schedule_phase("lobby", CONFIG, rays=RAYS, cell=CELL, output=tmp_path / "a.bin",
                                  picture=tmp_path / "a.png", **OPTIONS)
    scene, hemisphere = open_scene("lobby"), Hemisphere(*RAYS)
    points, normal = ceiling_points(scene)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, points)
    shelling = Shelling(geometry, CONFIG, cell=CELL)
    records = {number: hemisphere_record(hemisphere, geometry.coordinates, points[number - 1], normal)
               for number in (1, 4, 7, 10, 13)}
    plan = schedule(records[1], geometry, shelling.table, CONFIG, **OPTIONS)
    casts = {}
    for number, record in records.items():
        uses = np.zeros(len(geometry), dtype=np.int64)
        casts[number] = shelling.cast(record, plan.partition.sections, plan.subshells, references=uses)[1]
        assert report["cuf"][str(number)] == pytest.approx(uses[np.concatenate(plan.sets.patches)].sum() / uses.sum())
        known = plan.found.frequency > 0
        assert report["effectiveness"][str(number)] == pytest.approx(
            uses[known].sum() / np.sort(uses)[::-1][:known.sum()].sum())
    assert len(set(report["cuf"].values())) == len(set(report["effectiveness"].values())) == 5
    first = casts[1]
    figures = {"true": [one.tests for one in first], "rays": [one.rays for one in first],
               "cell_steps": [one.cell_steps for one in first], "estimated": plan.estimated,
               "estimated_cell_steps": plan.estimated_steps}
    assert report["balance"] == pytest.approx({name: max(values) / np.mean(values) for name, values in figures.items()})
    assert len({round(value, 6) for value in report["balance"].values()}) == 5
    assert f"{report['found']} of 227 patches found" in text
    assert f"tests {report['balance']['true']:.3f} (estimated {report['balance']['estimated']:.3f})" in text
    assert f"   13  {report['cuf']['13']:.3f}" in text
    lines = text.splitlines()[-4:]
    for number, (cluster, section) in enumerate(zip(report["clusters"], plan.partition.sections, strict=True)):
        which, columns, rows, rays, _, *others = lines[number].split()
        assert which == str(number)
        assert columns == f"{section.first_column}-{section.end_column - 1}"
        assert rows == f"{section.first_row}-{section.end_row - 1}"
        assert rays == str(cluster["rays"])
        assert others == [str(cluster[name]) for name in (
            "tests", "cell_steps", "patches", "resident", "subshells", "processor")]
        assert cluster == {
            "section": [section.first_column, section.end_column, section.first_row, section.end_row],
            "processor": plan.processor[number], "rays": first[number].rays, "tests": first[number].tests,
            "estimated_tests": pytest.approx(plan.estimated[number]), "cell_steps": first[number].cell_steps,
            "patches": first[number].patches, "resident": len(plan.sets.patches[number]),
            "subshells": len(plan.subshells[number])}
    np.testing.assert_array_equal(from_bytes((tmp_path / "a.bin").read_bytes())["rows"]["weight"],
                                  hemisphere.polar_weights)
    work = plan.found.frusta.share(plan.found.tests)
    light = 0.5 + 0.5 * work / work.max()
    colours = np.rint(label_colours(plan.partition.cluster_map) * light[..., None])
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.size == (1024, 256)
        np.testing.assert_array_equal(np.asarray(picture)[::32, ::32], colours)
        np.testing.assert_array_equal(np.asarray(picture)[31::32, 31::32], colours)
